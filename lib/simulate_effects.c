/* simulate_effects.c: see acting.h.
 *
 * With the drives' torque D_j at joint j (less the model's viscous friction and offset), an
 * effect's torque T_j and the level L_j of its friction beside the model's Coulomb C_j, what is
 * left for inertia and gravity is the load
 *     l_j = D_j - T_j - s_j (C_j + L_j(l_j)),
 * one scalar equation a joint: friction that depends on the load needs no acceleration. It is
 * solved by secants on the fixed point, exact in two steps where L is straight in l.
 * A sticking joint has a = 0; its friction f follows from the equations, its load is D_j - T_j - f,
 * and it holds while |f| <= C_j + L_j.
 *
 * Where a transmission twists, all this happens on the motor's side, a body of its own with the motor's
 * inertia I: I a = D - T - f - S, S the torque of the twisted spring, which then moves the joint beyond.
 * A base that sways by x adds to every absolute angle: the leg moves as if its knee stood at q_0 + x,
 * and its row of the equations, which is the torque between mount and leg, turns the mount back.
 */
#include "simulate_effects.h"

#include <math.h>
#include <string.h>

#include "effect_link.h"
#include "talus/math.h"

#define MAX_LOAD_STEPS 60
#define LOAD_TOLERANCE 1e-13

/* one joint at an instant */
typedef struct joint_side {
  tl_effect_instant now;
  double drive;  /* D_j */
  double torque; /* T_j */
  double level;  /* C_j + L_j */
  double z;      /* memory of its friction */
} joint_side;

/* torque and friction's level for the load and slip that side->now has. A level does not fall below 0;
 * friction with a memory takes its part of it, and acts as the memory says. */
static void apply(const tl_effect_dynamics *p, int joint, joint_side *side) {
  double torque, friction, memory = p->change[joint].memory_Nm;
  int i;

  side->now.friction_Nm = p->model->drive[joint].coulomb_Nm * side->now.slip +
                          p->model->drive[joint].viscous_Nms_rad * side->now.v;
  side->torque = memory * side->z;
  side->level = p->model->drive[joint].coulomb_Nm - memory;
  for (i = 0; i < p->effects; i++) {
    const tl_effect *e = &p->effect[i];
    if (e->kind->acts != TL_EFFECT_MECHANICAL || !tl_effect_at(e, joint)) continue;
    tl_effect_law(e, &side->now, &torque, &friction);
    side->torque += torque;
    side->level += friction;
  }
  if (side->level < 0.0) side->level = 0.0;
}

/* what the equation above gives for the load when the friction is that of load l */
static double load_after(const tl_effect_dynamics *p, int joint, double l, joint_side *side) {
  side->now.load_Nm = l;
  apply(p, joint, side);
  return side->drive - side->torque - side->now.slip * side->level;
}

/* the load of a sliding joint, and with it side->torque and side->level */
static tl_status solve_load(const tl_effect_dynamics *p, int joint, joint_side *side) {
  double l = side->drive, next = load_after(p, joint, l, side), after, bend;
  int i;

  for (i = 0; i < MAX_LOAD_STEPS; i++) {
    after = load_after(p, joint, next, side);
    if (!(fabs(after - next) > LOAD_TOLERANCE * (fabs(side->drive) + fabs(next)))) return TL_OK;
    /* Aitken's step: the secant of l -> load_after(l) - l */
    bend = (after - next) - (next - l);
    l = bend != 0.0 ? after - (after - next) * (after - next) / bend : after;
    next = load_after(p, joint, l, side);
  }
  return TL_ERR_NO_CONVERGENCE;
}

/* ---- bodies ---------------------------------------------------------------------- */

static int twists(const tl_effect_change *c) {
  return c->compliance_rad_Nm > 0.0;
}

void tl_effect_dynamics_init(tl_effect_dynamics *p) {
  int j;

  p->joints = tl_joint_count(p->model);
  if (p->effects == 0) return;
  p->link = *p->model;
  tl_clear_offsets(&p->link);
  for (j = 0; j < TL_BODIES; j++) p->change[j] = tl_effects_change(p->effect, p->effects, j);
  p->sways = p->change[TL_MAX_JOINTS].base_compliance_rad_Nm > 0.0;
  if (p->sways) p->base_inertia = tl_effect_dynamics_base_inertia(p->model, &p->change[TL_MAX_JOINTS]);
  for (j = 0; j < TL_MAX_JOINTS; j++) {
    p->link.drive[j].coulomb_Nm = p->link.drive[j].viscous_Nms_rad = 0.0;
    p->twists[j] = twists(&p->change[j]);
    if (p->twists[j]) tl_take_motor(&p->link, j, p->change[j].motor_share);
  }
}

int tl_effect_dynamics_is_dry(const tl_effect_dynamics *p, int joint) {
  int i;

  if (p->model->drive[joint].coulomb_Nm > 0.0) return 1;
  for (i = 0; i < p->effects; i++)
    if (p->effect[i].kind->dry && tl_effect_at(&p->effect[i], joint)) return 1;
  return 0;
}

void tl_effect_dynamics_begin(const tl_effect_dynamics *p, const tl_motion *motion, tl_link_state *beyond) {
  int j;

  if (beyond->begun || p->effects == 0) return;
  beyond->begun = 1;
  for (j = 0; j < p->joints; j++) {
    beyond->q[j] = motion->q[j];
    beyond->v[j] = motion->v[j];
  }
}

double tl_effect_dynamics_base_inertia(const tl_model *m, const tl_effect_change *base) {
  static const double hanging[TL_MAX_JOINTS] = {0.0, 0.0};
  double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS] = {0.0}, w = 2.0 * TL_PI * base->base_hz;

  tl_inertia_matrix(m, hanging, matrix);
  return 1.0 / (base->base_compliance_rad_Nm * w * w) - matrix[0];
}

/* torque of a twisted transmission, and what its damping takes; teeth in contact do not pull */
static double spring(const tl_effect_change *c, double twist, double rate, double *loss_W) {
  double side = twist < 0.0 ? -1.0 : 1.0, depth = fabs(twist) - 0.5 * c->gap_rad, torque, damping;

  if (!(depth > 0.0)) return 0.0;
  damping = c->damping_s * rate / c->compliance_rad_Nm;
  torque = side * depth / c->compliance_rad_Nm + damping;
  if (c->gap_rad > 0.0 && !(torque * side > 0.0)) return 0.0;
  *loss_W += damping * rate;
  return torque;
}

/* ---- sides ------------------------------------------------------------------------- */

static tl_status look_at(const tl_effect_dynamics *p, int joint, double t_s, double drive_Nm,
                         tl_joint_mode mode, const tl_motion *motion, joint_side *side) {
  const tl_model *m = p->model;
  int i;

  tl_effect_place_of(m, motion, joint, t_s - p->begin_s, &side->now);
  for (i = 0; i < p->effects; i++)
    if (p->effect[i].joint == TL_MAX_JOINTS && p->effect[i].kind->law)
      side->now.gravity_tilt_Nm = tl_effect_tilt_of(m, motion, joint);
  side->drive = drive_Nm - m->drive[joint].viscous_Nms_rad * motion->v[joint];
  side->drive -= tl_joint_offset(m, joint);
  if (mode == TL_MODE_FORWARD || mode == TL_MODE_BACKWARD) {
    side->now.slip = (double)mode;
    return solve_load(p, joint, side);
  }
  side->now.slip = 0.0;
  load_after(p, joint, side->drive, side);
  return TL_OK;
}

/* share of its level that a sticking joint's friction needs */
static double stick(const tl_effect_dynamics *p, int joint, double friction, joint_side *side) {
  side->now.slip = friction < 0.0 ? -1.0 : 1.0;
  side->now.load_Nm = side->drive - side->torque - friction;
  apply(p, joint, side);
  if (friction == 0.0) return 0.0;
  return friction / side->level; /* infinite where nothing holds it */
}

/* ---- accelerations ------------------------------------------------------------------- */

/* the equations of the n bodies: M a = left */
typedef struct equations {
  int n;
  int held[TL_BODIES]; /* 1: it sticks, a = 0 */
  double matrix[TL_BODIES][TL_BODIES], left[TL_BODIES], a[TL_BODIES];
} equations;

/* By elimination without pivoting, as M is positive definite. A body that is held has its row left out;
 * left[] of it becomes the torque that holds it. */
static tl_status solve(equations *e) {
  double m[TL_BODIES][TL_BODIES], b[TL_BODIES];
  int i, j, k;

  memcpy(m, e->matrix, sizeof m);
  memcpy(b, e->left, sizeof b);
  for (k = 0; k < e->n; k++) {
    if (e->held[k]) continue;
    if (!(m[k][k] > 0.0)) return TL_ERR_SINGULAR;
    for (i = k + 1; i < e->n; i++) {
      double lift = m[i][k] / m[k][k];
      if (e->held[i]) continue;
      for (j = k; j < e->n; j++) m[i][j] -= lift * m[k][j];
      b[i] -= lift * b[k];
    }
  }
  for (k = e->n - 1; k >= 0; k--) {
    e->a[k] = 0.0;
    if (e->held[k]) continue;
    for (j = k + 1; j < e->n; j++)
      if (!e->held[j]) b[k] -= m[k][j] * e->a[j];
    e->a[k] = b[k] / m[k][k];
  }
  for (k = 0; k < e->n; k++)
    for (j = 0; j < e->n && e->held[k]; j++) e->left[k] -= e->matrix[k][j] * e->a[j];
  return TL_OK;
}

/* inertia and what gravity and speed leave of it, in e->matrix and, taken off, e->left */
static void set_bodies(const tl_effect_dynamics *p, const tl_motion *motion, const tl_link_state *beyond,
                       equations *e, double *loss_W) {
  const int base = p->joints;
  double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS] = {0.0}, bias[TL_MAX_JOINTS] = {0.0, 0.0};
  tl_motion at_rest = *motion;
  int j, k;

  for (j = 0; j < TL_MAX_JOINTS; j++) {
    if (p->twists[j]) at_rest.q[j] = beyond->q[j];
    if (p->twists[j]) at_rest.v[j] = beyond->v[j];
    at_rest.a[j] = at_rest.slip[j] = 0.0;
  }
  if (p->sways) at_rest.q[0] += beyond->q[TL_MAX_JOINTS];
  if (p->sways) at_rest.v[0] += beyond->v[TL_MAX_JOINTS];
  tl_inverse(&p->link, &at_rest, bias);
  tl_joint_torque(&p->link, at_rest.q, bias, bias);
  tl_inertia_matrix(&p->link, at_rest.q, matrix);
  e->n = p->joints + p->sways;
  for (j = 0; j < p->joints; j++) {
    e->left[j] -= bias[j];
    for (k = 0; k < p->joints; k++) e->matrix[j][k] = matrix[j * p->joints + k];
  }
  if (p->sways) {
    const tl_effect_change *c = &p->change[TL_MAX_JOINTS];
    double w = 2.0 * TL_PI * c->base_hz, stiffness = 1.0 / c->base_compliance_rad_Nm;
    double x = beyond->q[TL_MAX_JOINTS], v = beyond->v[TL_MAX_JOINTS];
    double damping = 2.0 * c->base_share * stiffness / w * v;
    e->held[base] = 0;
    e->left[base] = -bias[0] - stiffness * x - damping;
    for (k = 0; k < p->joints; k++) e->matrix[base][k] = e->matrix[k][base] = e->matrix[0][k];
    e->matrix[base][base] = e->matrix[0][0] + p->base_inertia;
    *loss_W += damping * v;
  }
}

/* a joint whose transmission twists: its motor's side here and now, its spring for the body beyond */
static void move_motor(const tl_effect_dynamics *p, int j, tl_joint_mode mode, tl_motion *motion,
                       const tl_link_state *beyond, joint_side *side, equations *e, double *loss_W) {
  double turning, inertia = tl_motor_inertia(p->model, j, p->change[j].motor_share, motion, &turning), left;
  double torque = spring(&p->change[j], motion->q[j] - beyond->q[j], motion->v[j] - beyond->v[j], loss_W);

  left = side->drive - side->torque - side->now.slip * side->level - torque - turning;
  motion->a[j] = mode == TL_MODE_STICK ? 0.0 : left / inertia;
  if (mode == TL_MODE_STICK) motion->slip[j] = stick(p, j, left, side);
  e->left[j] = torque;
  e->held[j] = 0;
}

/* of Dahl's friction */
static double memory_rate(const tl_effect_change *c, double v, double z) {
  double rest = v < 0.0 ? 1.0 + z : 1.0 - z;

  if (c->memory_power > 1.0) rest = rest > 0.0 ? tl_pow(rest, c->memory_power) : 0.0;
  return v * rest / c->travel_rad;
}

tl_status tl_effect_dynamics_accelerate(const tl_effect_dynamics *p, double t_s, const tl_joint_mode *mode,
                                        const double torque[TL_MAX_JOINTS], tl_motion *motion,
                                        tl_link_state *beyond, double *loss_W) {
  double joint[TL_MAX_JOINTS] = {0.0, 0.0};
  joint_side side[TL_MAX_JOINTS];
  equations e;
  tl_status status;
  int j;

  *loss_W = 0.0;
  memset(&e, 0, sizeof e);
  tl_joint_torque(p->model, motion->q, torque, joint);
  for (j = 0; j < p->joints; j++) {
    side[j].z = beyond->z[j];
    status = look_at(p, j, t_s, joint[j], mode[j], motion, &side[j]);
    if (status != TL_OK) return status;
    motion->slip[j] = side[j].now.slip;
    *loss_W += (side[j].torque + side[j].level * motion->slip[j] +
                p->model->drive[j].viscous_Nms_rad * motion->v[j]) *
               motion->v[j];
    beyond->z_rate[j] =
        p->change[j].memory_Nm > 0.0 ? memory_rate(&p->change[j], motion->v[j], beyond->z[j]) : 0.0;
    e.held[j] = mode[j] == TL_MODE_STICK;
    e.left[j] = side[j].drive - side[j].torque - motion->slip[j] * side[j].level;
    if (p->twists[j]) move_motor(p, j, mode[j], motion, beyond, &side[j], &e, loss_W);
  }
  set_bodies(p, motion, beyond, &e, loss_W);
  status = solve(&e);
  if (status != TL_OK) return status;
  for (j = 0; j < p->joints; j++) {
    beyond->a[j] = e.a[j];
    if (p->twists[j]) continue;
    motion->a[j] = e.a[j];
    if (e.held[j]) motion->slip[j] = stick(p, j, e.left[j], &side[j]);
  }
  beyond->a[TL_MAX_JOINTS] = p->sways ? e.a[p->joints] : 0.0;
  return TL_OK;
}
