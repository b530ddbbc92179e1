/* twin_plant.c: geometry, inertia and forces of the leg on its mount, or of one joint alone */
#include "twin.h"

#include <math.h>
#include <string.h>

#define TWO_PI 6.28318530717958647692

/* Nut travel over joint angle: |AB| is fixed, the screw lies along x. */
static double travel(double ab, double bo, double ac, double phi, double *first, double *second) {
  double h = ac - bo * sin(phi), dh = -bo * cos(phi), ddh = bo * sin(phi), root = sqrt(ab * ab - h * h);
  double droot = -h * dh / root, ddroot = -(dh * dh + h * ddh + droot * droot) / root;

  *first = -bo * sin(phi) + droot;
  *second = -bo * cos(phi) + ddroot;
  return bo * cos(phi) + root;
}

/* Motor angle at a joint angle by the true linkage; the joint angle turns phi backwards. */
double twin_linkage(const twin_bench *b, double angle, double *ratio, double *bend) {
  double phi0 = TWO_PI / 2.0 - b->bof, d1, d2, now, scale = TWO_PI / b->lead,
         wave = b->wave_w * angle + b->wave_p;

  now = travel(b->ab, b->bo, b->ac, phi0 - angle, &d1, &d2);
  *ratio = -d1 * scale;
  *bend = d2 * scale;
  if (b->wave_a == 0.0) return (now - b->zero) * scale;
  *ratio += b->wave_a * b->wave_w * cos(wave);
  *bend -= b->wave_a * b->wave_w * b->wave_w * sin(wave);
  return (now - b->zero) * scale + b->wave_a * (sin(wave) - sin(b->wave_p));
}

double twin_linkage_known(const twin_bench *b, double angle, double *ratio) {
  double phi0 = TWO_PI / 2.0 - b->bof, d1, d2;
  double now = travel(b->n_ab, b->n_bo, b->n_ac, phi0 - angle, &d1, &d2);

  *ratio = -d1 * TWO_PI / b->lead;
  return (now - b->n_zero) * TWO_PI / b->lead;
}

void twin_zero(twin_bench *b) {
  double phi0 = TWO_PI / 2.0 - b->bof, d1, d2;

  b->zero = travel(b->ab, b->bo, b->ac, phi0, &d1, &d2);
  b->n_zero = travel(b->n_ab, b->n_bo, b->n_ac, phi0, &d1, &d2);
}

void twin_transmission(const twin_bench *b, int joint, double angle, double *motor, double *ratio,
                       double *bend) {
  if (joint == ANKLE && b->alone < 0.5) {
    *motor = twin_linkage(b, angle, ratio, bend);
    return;
  }
  *motor = b->ratio * angle;
  *ratio = b->ratio;
  *bend = 0.0;
}

int twin_joints(const twin_bench *b) {
  return b->alone > 0.5 ? 1 : JOINTS;
}

/* Columns that span the velocities that the bench allows; returns how many. */
size_t twin_basis(const twin_bench *b, double basis[COORDS][COORDS]) {
  int flex_k = twin_flexible(&b->joint[KNEE]), flex_a = twin_flexible(&b->joint[ANKLE]);
  size_t n = 0;

  memset(basis, 0, COORDS * sizeof basis[0]);
  basis[SHANK][n] = 1.0;
  if (!flex_k) basis[DRIVE_K][n] = 1.0;
  if (b->alone > 0.5) { /* the rest stands still */
    if (flex_k) basis[DRIVE_K][++n] = 1.0;
    return n + 1;
  }
  if (!flex_a) basis[DRIVE_A][n] = -1.0;
  n++;
  basis[FOOT][n] = 1.0;
  if (!flex_a) basis[DRIVE_A][n] = 1.0;
  n++;
  if (flex_k) basis[DRIVE_K][n++] = 1.0;
  if (flex_a) basis[DRIVE_A][n++] = 1.0;
  if (b->x_mass > 0.0) basis[X][n++] = 1.0;
  if (b->z_mass > 0.0) basis[Z][n++] = 1.0;
  if (b->phi_inertia > 0.0) {
    basis[PHI][n] = 1.0;
    if (!flex_k) basis[DRIVE_K][n] = -1.0;
    n++;
  }
  return n;
}

typedef struct {
  double shank_inertia, foot_inertia, shank_moment, foot_moment, mass, coupling, toe_moment;
} bodies;

/* A payload that jumps on at its time belongs to the foot. */
static bodies weigh(const twin_bench *b, double t) {
  double extra = b->jump_mass != 0.0 && t > b->jump_s ? b->jump_mass : 0.0, mf = b->mf + extra;
  double foot_moment = b->mf * b->df + extra * b->jump_r;
  bodies w;

  if (extra != 0.0 && b->jump_length > 0.0 && t > b->jump_s + b->jump_length) {
    mf = b->mf;
    foot_moment = b->mf * b->df;
    extra = 0.0;
  }
  w.mass = b->ms + b->mm + mf;
  w.shank_moment = b->ms * b->ds + b->mm * b->dma + mf * b->ls;
  w.foot_moment = foot_moment;
  w.shank_inertia = b->i1 * (1.0 - b->joint[KNEE].rotor_share) + b->ms * b->ds * b->ds +
                    b->mm * b->dma * b->dma + mf * b->ls * b->ls;
  w.foot_inertia = b->i_f + b->mf * b->df * b->df + extra * b->jump_r * b->jump_r;
  w.coupling = foot_moment * b->ls;
  w.toe_moment = 0.0;
  return w;
}

void twin_mass(const twin_bench *b, double t, const twin_state *s, double mass[COORDS][COORDS]) {
  bodies w = weigh(b, t);
  const double *q = s->q;
  double ka = s->ratio[ANKLE], sway[3] = {1.0, 0.0, b->phi_lever}, rise[3] = {0.0, 1.0, 0.0};
  int i, k;

  memset(mass, 0, COORDS * sizeof mass[0]);
  for (i = 0; i < 3; i++)
    for (k = 0; k < 3; k++) mass[i][k] = w.mass * (sway[i] * sway[k] + rise[i] * rise[k]);
  mass[X][X] += b->x_mass;
  mass[Z][Z] += b->z_mass;
  mass[PHI][PHI] += b->phi_inertia;
  for (i = 0; i < 3; i++) {
    mass[i][SHANK] = mass[SHANK][i] = w.shank_moment * (sway[i] * cos(q[SHANK]) + rise[i] * sin(q[SHANK]));
    mass[i][FOOT] = mass[FOOT][i] = w.foot_moment * (sway[i] * cos(q[FOOT]) + rise[i] * sin(q[FOOT]));
  }
  mass[SHANK][SHANK] = w.shank_inertia;
  mass[FOOT][FOOT] = w.foot_inertia;
  mass[SHANK][FOOT] = mass[FOOT][SHANK] = w.coupling * cos(q[SHANK] - q[FOOT]);
  mass[DRIVE_K][DRIVE_K] = b->i1 * b->joint[KNEE].rotor_share;
  mass[DRIVE_A][DRIVE_A] = b->ima * ka * ka;
}

static void inertia_and_gravity(const twin_bench *b, const twin_state *s, double t, double *force) {
  bodies w = weigh(b, t);
  const double *q = s->q, *v = s->v;
  double cross = w.coupling * sin(q[SHANK] - q[FOOT]), sway;

  sway =
      w.shank_moment * sin(q[SHANK]) * v[SHANK] * v[SHANK] + w.foot_moment * sin(q[FOOT]) * v[FOOT] * v[FOOT];
  force[X] += sway - b->x_k * q[X] - b->x_c * v[X];
  force[PHI] += b->phi_lever * sway - b->phi_k * q[PHI] - b->phi_c * v[PHI];
  force[Z] += -w.shank_moment * cos(q[SHANK]) * v[SHANK] * v[SHANK] -
              w.foot_moment * cos(q[FOOT]) * v[FOOT] * v[FOOT] - b->z_k * q[Z] - b->z_c * v[Z];
  force[SHANK] += -cross * v[FOOT] * v[FOOT] - b->gravity * w.shank_moment * sin(q[SHANK] + b->tilt);
  force[FOOT] +=
      cross * v[SHANK] * v[SHANK] - b->gravity * w.foot_moment * sin(q[FOOT] + b->tilt + b->tilt_foot);
  force[DRIVE_A] -= b->ima * s->ratio[ANKLE] * s->bend[ANKLE] * v[DRIVE_A] * v[DRIVE_A];
}

/* What drags or blows at the foot, and what ties both joints together. */
static void outside(const twin_bench *b, const twin_state *s, double t, double *force) {
  const double *q = s->q, *v = s->v;
  double shaft = b->ls * cos(q[SHANK]), toe = b->toe_r * cos(q[FOOT]), speed, pull, knee, ankle;

  if (b->drag != 0.0) {
    speed = shaft * v[SHANK] + toe * v[FOOT];
    pull = -b->drag * speed * pow(fabs(speed) + 1e-9, b->drag_power - 1.0);
    force[SHANK] += shaft * pull;
    force[FOOT] += toe * pull;
  }
  if (b->fan_a != 0.0)
    force[b->fan_on > 0.5 ? FOOT : SHANK] += b->fan_a * sin(b->fan_w * (t + b->session_s) + b->fan_p);
  if (b->cable != 0.0 || b->cable_2 != 0.0) {
    double k = twin_joint_angle(q, KNEE), a = twin_joint_angle(q, ANKLE);
    knee = -b->cable * a - 2.0 * b->cable_2 * k * a;
    ankle = -b->cable * k - b->cable_2 * k * k;
    force[SHANK] += knee - ankle;
    force[FOOT] += ankle;
    force[PHI] -= knee;
  }
}

static void add_to_joint(double *force, int joint, double torque) {
  force[joint == KNEE ? SHANK : FOOT] += torque;
  force[joint == KNEE ? PHI : SHANK] -= torque;
}

/* All forces but dry friction. */
void twin_forces(const twin_bench *b, twin_state *s, double t, double *force) {
  int joint;

  memset(force, 0, COORDS * sizeof force[0]);
  inertia_and_gravity(b, s, t, force);
  outside(b, s, t, force);
  for (joint = 0; joint < twin_joints(b); joint++) {
    const twin_joint *j = &b->joint[joint];
    int at = joint == KNEE ? DRIVE_K : DRIVE_A;
    double drive, link, ripple = 0.0, load = 1.0;
    int i;

    if (j->ripple_load > 0.5) load = s->load[joint];
    for (i = 0; i < MAX_WAVES; i++)
      if (j->ripple_a[i] != 0.0)
        ripple += j->ripple_a[i] * load * sin(j->ripple_n[i] * s->motor[joint] + j->ripple_p[i]);
    drive = s->load_all[joint] = s->ratio[joint] * twin_motor_torque(b, s, joint, t);
    s->applied[joint] = twin_smooth_friction(b, s, joint, t) + twin_memory(b, s, joint);
    force[at] += drive + ripple - s->applied[joint];
    add_to_joint(force, joint, twin_beside(b, s, joint, t));
    if (twin_flexible(j)) {
      double beyond =
          j->viscous * j->viscous_share; /* of viscous friction, on the joint's side of the spring */
      force[at] += beyond * s->v[at];
      add_to_joint(force, joint, -beyond * twin_joint_angle(s->v, joint));
      twin_coupling(b, s, joint, &drive, &link);
      force[at] += drive;
      add_to_joint(force, joint, link);
    }
  }
}

/* Kinetic energy, gravity's and the linear springs beside the joints (for the test of the balance). */
double twin_energy(const twin_bench *b, double t, const twin_state *s) {
  bodies w = weigh(b, t);
  double mass[COORDS][COORDS], sum = 0.0;
  int i, k;

  twin_mass(b, t, s, mass);
  for (i = 0; i < COORDS; i++)
    for (k = 0; k < COORDS; k++) sum += 0.5 * s->v[i] * mass[i][k] * s->v[k];
  for (i = 0; i < JOINTS; i++) {
    double x = twin_joint_angle(s->q, i) - b->joint[i].spring_zero;
    if (b->joint[i].spring_form == 1.0) sum += 0.5 * b->joint[i].spring_k * x * x;
  }
  sum += 0.5 * (b->x_k * s->q[X] * s->q[X] + b->z_k * s->q[Z] * s->q[Z] + b->phi_k * s->q[PHI] * s->q[PHI]);
  return sum - b->gravity *
                   (w.shank_moment * cos(s->q[SHANK] + b->tilt) + w.foot_moment * cos(s->q[FOOT] + b->tilt));
}
