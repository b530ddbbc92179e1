/* twin_step.c: one step in time: velocities first, with dry friction solved at the end of the step, so that a joint
 * that sticks stands still exactly and none chatters (Moreau 1988) */
#include "twin.h"

#include <math.h>
#include <string.h>

/* Cholesky of the n x n matrix, in place. */
static void factorise(double a[COORDS][COORDS], size_t n) {
  size_t i, j, k;

  for (j = 0; j < n; j++) {
    for (k = 0; k < j; k++) a[j][j] -= a[j][k] * a[j][k];
    a[j][j] = sqrt(a[j][j]);
    for (i = j + 1; i < n; i++) {
      for (k = 0; k < j; k++) a[i][j] -= a[i][k] * a[j][k];
      a[i][j] /= a[j][j];
    }
  }
}

static void solve(double a[COORDS][COORDS], size_t n, double *x) {
  size_t i, k;

  for (i = 0; i < n; i++) {
    for (k = 0; k < i; k++) x[i] -= a[i][k] * x[k];
    x[i] /= a[i][i];
  }
  for (i = n; i-- > 0;) {
    for (k = i + 1; k < n; k++) x[i] -= a[k][i] * x[k];
    x[i] /= a[i][i];
  }
}

/* y = basis^T x */
static void reduce(double basis[COORDS][COORDS], size_t n, const double *x, double *y) {
  size_t i, k;

  for (k = 0; k < n; k++) {
    y[k] = 0.0;
    for (i = 0; i < COORDS; i++) y[k] += basis[i][k] * x[i];
  }
}

static void expand(double basis[COORDS][COORDS], size_t n, const double *y, double *x) {
  size_t i, k;

  for (i = 0; i < COORDS; i++) {
    x[i] = 0.0;
    for (k = 0; k < n; k++) x[i] += basis[i][k] * y[k];
  }
}

/* Where dry friction acts: at each drive, and at the joint beyond a spring if part of it stands there. */
static int contacts(const twin_bench *b, const twin_state *s, double t, twin_contact *c) {
  int joint, n = 0;

  for (joint = 0; joint < twin_joints(b); joint++) {
    double up = twin_dry(b, s, joint, t, 1.0), down = twin_dry(b, s, joint, t, -1.0);
    double beyond = twin_flexible(&b->joint[joint]) ? b->joint[joint].link_share : 0.0;
    memset(&c[n], 0, sizeof c[n]);
    c[n].direction[joint == KNEE ? DRIVE_K : DRIVE_A] = 1.0;
    c[n].up = up * (1.0 - beyond);
    c[n].down = down * (1.0 - beyond);
    c[n++].joint = joint;
    if (beyond <= 0.0) continue;
    memset(&c[n], 0, sizeof c[n]);
    c[n].direction[joint == KNEE ? SHANK : FOOT] = 1.0;
    c[n].direction[joint == KNEE ? PHI : SHANK] = -1.0;
    c[n].up = up * beyond;
    c[n].down = down * beyond;
    c[n++].joint = -1;
  }
  return n;
}

/* Friction forces such that each contact sticks within its levels or slides against one (Gauss-Seidel). */
static void stick_or_slide(twin_contact *c, int n, double a[MAX_CONTACTS][MAX_CONTACTS],
                           const double *speed) {
  int round, i, k;

  for (round = 0; round < 200; round++) {
    double change = 0.0;
    for (i = 0; i < n; i++) {
      double free_speed = speed[i], force;
      for (k = 0; k < n; k++)
        if (k != i) free_speed += a[i][k] * c[k].force;
      force = -free_speed / a[i][i];
      if (force < -c[i].up) force = -c[i].up;
      if (force > c[i].down) force = c[i].down;
      change = fmax(change, fabs(force - c[i].force));
      c[i].force = force;
    }
    if (change < 1e-11) return;
  }
}

/* Torque through the gear as the step has shown it: the motor's, less its rotor's inertia, less friction. */
static void note_load(const twin_bench *b, twin_state *s, int joint) {
  int at = joint == KNEE ? DRIVE_K : DRIVE_A;
  double ratio = s->ratio[joint], rotor;

  rotor = joint == KNEE ? b->i1 * b->joint[KNEE].rotor_share * s->a[at]
                        : b->ima * ratio * (ratio * s->a[at] + s->bend[joint] * s->v[at] * s->v[at]);
  s->load[joint] = s->load_all[joint] - s->applied[joint];
  if (b->joint[joint].load_rotor < 0.5) s->load[joint] -= rotor;
}

static void walk(const twin_bench *b, twin_state *s) {
  int joint;

  for (joint = 0; joint < twin_joints(b); joint++) {
    const twin_joint *j = &b->joint[joint];
    if (j->walk_size == 0.0) continue;
    s->walk[joint] += -s->walk[joint] * b->step_s / j->walk_tau +
                      j->walk_size * sqrt(2.0 * b->step_s / j->walk_tau) * twin_normal(&s->random);
  }
}

/* What one step works with: the basis of the free velocities, the factored mass, and the contacts in it. */
typedef struct {
  double basis[COORDS][COORDS], mass[COORDS][COORDS], free[COORDS];
  double direction[MAX_CONTACTS][COORDS],
      answer[MAX_CONTACTS][COORDS]; /* of each contact, and mass^-1 of it */
  size_t n;
  twin_contact contact[MAX_CONTACTS];
  int contacts;
} work;

/* mass <- basis^T mass basis, factored; free <- the accelerations without dry friction. */
static void free_motion(const twin_bench *b, twin_state *s, double t, work *w) {
  double full[COORDS][COORDS], column[COORDS], force[COORDS];
  size_t i, k, r;

  twin_mass(b, t, s, full);
  for (k = 0; k < w->n; k++) {
    for (i = 0; i < COORDS; i++) {
      column[i] = 0.0;
      for (r = 0; r < COORDS; r++) column[i] += full[i][r] * w->basis[r][k];
    }
    reduce(w->basis, w->n, column, w->mass[k]);
  }
  factorise(w->mass, w->n);
  twin_forces(b, s, t, force);
  reduce(w->basis, w->n, force, w->free);
  solve(w->mass, w->n, w->free);
}

/* Adds dry friction's share to the accelerations. */
static void dry_friction(const twin_bench *b, const twin_state *s, double t, work *w) {
  double a[MAX_CONTACTS][MAX_CONTACTS], speed[MAX_CONTACTS];
  size_t i;
  int p, r;

  w->contacts = contacts(b, s, t, w->contact);
  for (p = 0; p < w->contacts; p++) {
    reduce(w->basis, w->n, w->contact[p].direction, w->direction[p]);
    memcpy(w->answer[p], w->direction[p], sizeof w->direction[p]);
    solve(w->mass, w->n, w->answer[p]);
  }
  for (p = 0; p < w->contacts; p++) {
    speed[p] = 0.0;
    for (i = 0; i < COORDS; i++) speed[p] += w->contact[p].direction[i] * s->v[i];
    for (i = 0; i < w->n; i++) speed[p] += w->direction[p][i] * b->step_s * w->free[i];
    for (r = 0; r < w->contacts; r++) {
      a[p][r] = 0.0;
      for (i = 0; i < w->n; i++) a[p][r] += b->step_s * w->direction[p][i] * w->answer[r][i];
    }
  }
  stick_or_slide(w->contact, w->contacts, a, speed);
  for (p = 0; p < w->contacts; p++)
    for (i = 0; i < w->n; i++) w->free[i] += w->answer[p][i] * w->contact[p].force;
}

/* Energy that the motors put in and that friction takes, by the mean velocity of the step. */
static void account(const twin_bench *b, twin_state *s, const double *middle, const work *w) {
  int joint, p, i;

  for (joint = 0; joint < twin_joints(b); joint++) {
    double way = middle[joint == KNEE ? DRIVE_K : DRIVE_A] * b->step_s;
    s->work_in += s->load_all[joint] * way;
    s->work_lost += s->applied[joint] * way;
  }
  for (p = 0; p < w->contacts; p++) {
    const twin_contact *c = &w->contact[p];
    for (i = 0; i < COORDS; i++) s->work_lost -= c->force * c->direction[i] * middle[i] * b->step_s;
    if (c->joint >= 0) s->applied[c->joint] -= c->force;
  }
}

void twin_step(const twin_bench *b, twin_state *s, double t) {
  work w;
  double middle[COORDS];
  int i, joint;

  for (joint = 0; joint < twin_joints(b); joint++)
    twin_transmission(b, joint, s->q[joint == KNEE ? DRIVE_K : DRIVE_A], &s->motor[joint], &s->ratio[joint],
                      &s->bend[joint]);
  w.n = twin_basis(b, w.basis);
  free_motion(b, s, t, &w);
  dry_friction(b, s, t, &w);
  expand(w.basis, w.n, w.free, s->a);
  for (i = 0; i < COORDS; i++) middle[i] = s->v[i] + 0.5 * b->step_s * s->a[i];
  account(b, s, middle, &w);
  for (joint = 0; joint < twin_joints(b); joint++) note_load(b, s, joint);
  for (i = 0; i < COORDS; i++) {
    s->v[i] += b->step_s * s->a[i];
    s->q[i] += b->step_s * s->v[i];
  }
  walk(b, s);
}
