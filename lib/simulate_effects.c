/* simulate_effects.c: see simulate_effects.h.
 *
 * With the drives' torque D_j at joint j (less the model's viscous friction and offset), an
 * effect's torque T_j and the level L_j of its friction beside the model's Coulomb C_j, what is
 * left for inertia and gravity is the load
 *     l_j = D_j - T_j - s_j (C_j + L_j(l_j)),
 * one scalar equation a joint: friction that depends on the load needs no acceleration. It is
 * solved by secants on the fixed point, exact in two steps where T and L are straight in l.
 * A sticking joint has a = 0; its friction f follows from the equations, its load is D_j - T_j - f,
 * and it holds while |f| <= C_j + L_j.
 *
 * Where a transmission twists, all this happens on the motor's side, a body of its own with the motor's
 * inertia I: I a = D - T - f - S - G, S the torque of the twisted spring (tl_spring_torque) and G that of dry friction
 * between motor and link, which then move the link, whose own friction stands against it. Where that friction sticks, G is
 * what keeps both together: one body, unless one of them is held; where both are, the motor's own friction comes first.
 * A joint that runs ahead of its motor by e(q) stands at q + e: with J = 1 + e' its torque and inertia come back to the
 * motor as J T and J M J, by virtual work.
 * A mount that turns by x adds to every absolute angle: the leg moves as if its knee stood at q_0 + x, and its row of
 * the equations, the torque between mount and leg, turns the mount back. One that sways or rises accelerates the leg as
 * one more gravity, and feels the leg's forces. The modes are those of mount and leg together, as a modal test of the bench
 * finds them: with the leg hanging still none moves another, so that any number of them, of one sort or of several, is
 * their sum; what couples two is by how much the leg's inertia differs from that of the hanging leg.
 */
#include "simulate_effects.h"

#include <math.h>
#include <string.h>

#include "math_inline.h"
#include "talus/experimental/hysteresis.h"
#include "talus/math.h"

#define MAX_LOAD_STEPS 60
#define LOAD_TOLERANCE 1e-13
#define MAX_ROTOR_STEPS 30
#define ROTOR_TOLERANCE 1e-12

/* one joint at an instant */
typedef struct joint_side {
  tl_effect_instant now;
  double drive;  /* D_j */
  double torque; /* T_j */
  double level;  /* C_j + L_j */
  double z;      /* memory of its friction */
  /* of a motor whose transmission twists: what is left for its inertia but for the drag, and the latter on the link */
  double left, inertia, drag;
  double gear, bend; /* the link of a rigid one would have gear a + bend */
  /* where drag sticks: motor and link are one body; a motor at rest holds the link; both rest */
  int joins, holds, rests;
} joint_side;

/* torque and friction's level for the load and slip that side->now has. A level does not fall below 0;
 * friction with a memory takes its part of it, and acts as the memory says. */
static void apply(const tl_effect_dynamics *p, int joint, joint_side *side) {
  double torque, friction, memory = p->change[joint].memory_Nm;
  int i;

  side->now.friction_Nm = p->model->drive[joint].coulomb_Nm * side->now.slip +
                          p->model->drive[joint].viscous_Nms_rad * side->now.v;
  side->torque = memory * side->z;
  side->level = p->model->drive[joint].coulomb_Nm * (1.0 - p->change[joint].friction_share) - memory;
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

static tl_spring spring_of(const tl_effect_change *c) {
  tl_spring spring = {1.0 / c->compliance_rad_Nm, c->gap_rad,           c->soft_rad,
                      1.0 - c->soft_loss,         c->hardening_Nm_rad3, c->damping_s / c->compliance_rad_Nm};

  return spring;
}

/* does a friction at the joint grow with the load less the rotor's inertia, and is there one? */
static int needs_rotor(const tl_effect_dynamics *p, int joint) {
  int i;

  for (i = 0; i < p->effects; i++) {
    const tl_effect *e = &p->effect[i];
    if (e->kind->rotor_share && tl_effect_at(e, joint) && e->value[e->kind->rotor_share] != 1.0) return 1;
  }
  return 0;
}

/* ---- mount ----------------------------------------------------------------------- */

/* A mount's force on the leg by its acceleration, and the leg's on it: lever arms at both joints, and the pull of what
 * turns with a speed. Moments of shank and foot [kg m], each times the sine and the cosine of its absolute angle. */
typedef struct mount_arms {
  double arm[TL_MAX_JOINTS], pull;
} mount_arms;

static mount_arms arms_of(const tl_model *weightless, const tl_motion *now, int rises) {
  double moment[2][TL_MAX_JOINTS], side = rises ? 1.0 : -1.0, foot_v = now->v[0] + now->v[1];
  const double *along = moment[rises], *across = moment[!rises];
  tl_motion still;
  mount_arms m;

  memset(&still, 0, sizeof still);
  memcpy(still.q, now->q, sizeof still.q);
  tl_inverse(weightless, &still, moment[0]);
  moment[1][0] = tl_effect_tilt_of(weightless, &still, 0);
  moment[1][1] = tl_effect_tilt_of(weightless, &still, 1);
  m.arm[0] = across[0];
  m.arm[1] = across[1];
  /* an end goes on a circle: r sin q to the front, -r cos q upwards */
  m.pull = side * ((along[0] - along[1]) * now->v[0] * now->v[0] + along[1] * foot_v * foot_v);
  return m;
}

static tl_model weightless_of(const tl_model *m) {
  tl_model weightless = tl_effect_bare_model(m);

  weightless.gravity_m_s2 = 1.0;
  return weightless;
}

static double mode_inertia(const tl_effect_mount *mount) {
  double w = 2.0 * TL_PI * mount->frequency_Hz;

  return 1.0 / (mount->compliance * w * w);
}

/* inertia about the knee of the leg that hangs still */
static double hanging_inertia(const tl_model *m) {
  static const tl_motion hanging;
  double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS] = {0.0};

  tl_inertia_matrix(m, hanging.q, matrix);
  return matrix[0];
}

/* a mode's inertia with the knee of the leg that hangs still */
static double coupling_at_rest(const tl_model *m, const tl_effect_mount *mount) {
  static const tl_motion hanging;
  tl_model weightless;

  if (mount->mode == TL_MOUNT_TURNS) return hanging_inertia(m);
  weightless = weightless_of(m);
  return arms_of(&weightless, &hanging, mount->mode == TL_MOUNT_RISES).arm[0];
}

/* the inertia matrix of knee and modes is positive definite while their shares are below 1 together */
int tl_simulation_mount_rings(const tl_model *m, const tl_effect_mount *mount, int modes) {
  double shares = 0.0, coupling;
  int k;

  for (k = 0; k < modes; k++) {
    coupling = coupling_at_rest(m, &mount[k]);
    shares += coupling * coupling / (mode_inertia(&mount[k]) * hanging_inertia(m));
  }
  return shares < 1.0;
}

static void init_joint(tl_effect_dynamics *p, int j) {
  const tl_effect_change *c = &p->change[j];

  p->link.drive[j].coulomb_Nm = p->link.drive[j].viscous_Nms_rad = 0.0;
  p->needs_rotor[j] = j < p->joints && needs_rotor(p, j);
  p->twists[j] = c->compliance_rad_Nm > 0.0;
  if (!p->twists[j]) return;
  p->spring[j] = spring_of(c);
  tl_take_motor(&p->link, j, c->motor_share);
}

void tl_effect_dynamics_init(tl_effect_dynamics *p) {
  const tl_effect_change *base = &p->change[TL_MAX_JOINTS];
  int j;

  p->joints = tl_joint_count(p->model);
  if (p->effects == 0) return;
  p->link = *p->model;
  tl_clear_offsets(&p->link);
  for (j = 0; j <= TL_MAX_JOINTS; j++) p->change[j] = tl_effects_change(p->effect, p->effects, j);
  p->modes = base->mount_modes < TL_MOUNT_MODES ? base->mount_modes : TL_MOUNT_MODES;
  p->moves = 0;
  for (j = 0; j < p->modes; j++) {
    p->mount_inertia[j] = mode_inertia(&base->mount[j]);
    p->mount_coupling[j] = coupling_at_rest(p->model, &base->mount[j]);
    p->moves |= base->mount[j].mode != TL_MOUNT_TURNS;
  }
  for (j = 0; j < TL_MAX_JOINTS; j++) init_joint(p, j);
  if (!p->moves) return;
  p->weightless = weightless_of(p->model);
}

int tl_effect_dynamics_is_dry(const tl_effect_dynamics *p, int joint) {
  int i;

  if (p->model->drive[joint].coulomb_Nm > 0.0 && (!p->effects || p->change[joint].friction_share < 1.0))
    return 1;
  for (i = 0; i < p->effects; i++)
    if (p->effect[i].kind->dry && tl_effect_at(&p->effect[i], joint)) return 1;
  return 0;
}

double tl_effect_dynamics_link_friction(const tl_effect_dynamics *p, int joint) {
  if (p->effects == 0 || !p->twists[joint]) return 0.0;
  return p->change[joint].friction_share * p->model->drive[joint].coulomb_Nm;
}

double tl_effect_dynamics_drag(const tl_effect_dynamics *p, int joint) {
  return p->effects == 0 || !p->twists[joint] ? 0.0 : p->change[joint].drag_Nm;
}

double tl_effect_dynamics_speed(const tl_effect_dynamics *p, int joint, const tl_motion *motion) {
  double ahead[3];

  tl_effect_dynamics_ahead(p->model, &p->change[joint], joint, motion->q[joint], ahead);
  return motion->v[joint] * (1.0 + ahead[1]);
}

void tl_effect_dynamics_begin(const tl_effect_dynamics *p, const tl_motion *motion, tl_link_state *link) {
  int j;

  if (link->begun || p->effects == 0) return;
  link->begun = 1;
  for (j = 0; j < p->joints; j++) {
    link->q[j] = motion->q[j];
    link->v[j] = motion->v[j];
  }
}

/* ---- sides ------------------------------------------------------------------------- */

/* viscous friction on the motor's side */
static double viscous(const tl_effect_dynamics *p, int joint) {
  return p->model->drive[joint].viscous_Nms_rad * (1.0 - p->change[joint].viscous_share);
}

/* what of its constant torque acts on a link that is not rigid with its motor */
static double link_offset(const tl_effect_dynamics *p, int joint) {
  return p->twists[joint] ? p->change[joint].offset_share * tl_joint_offset(p->model, joint) : 0.0;
}

double tl_effect_dynamics_offset_W(const tl_effect_dynamics *p, int joint, const tl_motion *motion,
                                   const tl_link_state *link) {
  double whole = tl_joint_offset(p->model, joint) * motion->v[joint];

  if (p->effects == 0 || !p->twists[joint]) return whole;
  return whole + link_offset(p, joint) * (link->v[joint] - motion->v[joint]);
}

static tl_status look_at(const tl_effect_dynamics *p, int joint, double t_s, double drive_Nm,
                         tl_joint_mode mode, const tl_motion *motion, joint_side *side) {
  const tl_model *m = p->model;
  int i;

  tl_effect_place_of(m, motion, joint, t_s - p->begin_s, &side->now);
  for (i = 0; i < p->effects; i++)
    if (p->effect[i].joint == TL_MAX_JOINTS && p->effect[i].kind->law)
      side->now.gravity_tilt_Nm = tl_effect_tilt_of(m, motion, joint);
  if (p->needs_rotor[joint]) side->now.rotor_Nm = tl_rotor_torque(m, motion, joint);
  side->drive = drive_Nm - viscous(p, joint) * motion->v[joint];
  side->drive -= tl_joint_offset(m, joint) - link_offset(p, joint);
  if (mode == TL_MODE_FORWARD || mode == TL_MODE_BACKWARD) {
    side->now.slip = (double)mode;
    return solve_load(p, joint, side);
  }
  side->now.slip = 0.0;
  load_after(p, joint, side->drive, side);
  return TL_OK;
}

/* Share of its level that a sticking joint's friction needs, where torque was what an effect takes at a load without
 * friction: one that depends on the load takes its part of it. */
static double stick(const tl_effect_dynamics *p, int joint, double friction, joint_side *side) {
  double torque = side->torque;

  side->now.slip = friction < 0.0 ? -1.0 : 1.0;
  side->now.load_Nm = side->drive - torque - friction;
  apply(p, joint, side);
  friction -= side->torque - torque;
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

void tl_effect_dynamics_ahead(const tl_model *m, const tl_effect_change *c, int joint, double q,
                              double ahead[3]) {
  const tl_transmission *t = &m->drive[joint].transmission;
  double wave[3], ratio, slope;

  ahead[0] = ahead[1] = ahead[2] = 0.0;
  if (c->ripple.n == 0) return;
  tl_transmission_ratio(t, q, &ratio, &slope);
  tl_effect_waves_at(&c->ripple, tl_transmission_motor_angle(t, q), wave);
  ahead[0] = wave[0];
  ahead[1] = wave[1] * ratio;
  ahead[2] = wave[2] * ratio * ratio + wave[1] * slope;
}

/* what the link's motion is, all but its accelerations: a[] of a joint that is not moved by itself is what its speed
 * leaves of it */
static void link_motion(const tl_effect_dynamics *p, const tl_motion *motion, const tl_link_state *link,
                        double ahead[TL_MAX_JOINTS][3], tl_motion *now) {
  int j, k;

  *now = *motion;
  for (j = 0; j < TL_MAX_JOINTS; j++) {
    now->a[j] = now->slip[j] = 0.0;
    if (p->twists[j]) {
      now->q[j] = link->q[j];
      now->v[j] = link->v[j];
    } else if (p->change[j].ripple.n > 0) {
      now->q[j] += ahead[j][0];
      now->v[j] *= 1.0 + ahead[j][1];
      now->a[j] = ahead[j][2] * motion->v[j] * motion->v[j];
    }
  }
  for (k = 0; k < p->modes; k++) {
    if (p->change[TL_MAX_JOINTS].mount[k].mode != TL_MOUNT_TURNS) continue;
    now->q[0] += link->q[TL_MAX_JOINTS + k];
    now->v[0] += link->v[TL_MAX_JOINTS + k];
  }
}

/* row and column of the mount's mode k, after the joints' */
static void set_mode(const tl_effect_dynamics *p, int k, const tl_motion *now, const tl_link_state *link,
                     const double *bias, const double *by_motor, equations *e, double *loss_W) {
  const tl_effect_mount *c = &p->change[TL_MAX_JOINTS].mount[k];
  double w = 2.0 * TL_PI * c->frequency_Hz, stiffness = 1.0 / c->compliance;
  double x = link->q[TL_MAX_JOINTS + k], v = link->v[TL_MAX_JOINTS + k], whole = p->mount_inertia[k];
  double damping = 2.0 * c->damping_ratio * stiffness / w * v, pull = bias[0], arm0 = 0.0;
  const int row = p->joints + k;
  int i;

  if (c->mode == TL_MOUNT_TURNS) {
    for (i = 0; i < p->joints; i++) e->matrix[row][i] = e->matrix[0][i] / by_motor[0];
    arm0 = e->matrix[0][0] / (by_motor[0] * by_motor[0]);
    whole = whole - p->mount_coupling[k] + arm0;
  } else {
    mount_arms arms = arms_of(&p->weightless, now, c->mode == TL_MOUNT_RISES);
    for (i = 0; i < p->joints; i++) e->matrix[row][i] = arms.arm[i] * by_motor[i];
    pull = arms.pull;
    for (i = 0; i < p->joints; i++) pull += arms.arm[i] * now->a[i];
    arm0 = arms.arm[0];
  }
  /* what turns is pulled along by every other mode; what the leg weighs does not change as it moves */
  for (i = 0; i < k; i++)
    if (p->change[TL_MAX_JOINTS].mount[i].mode == TL_MOUNT_TURNS)
      e->matrix[row][p->joints + i] = arm0 - p->mount_coupling[k];
    else if (c->mode == TL_MOUNT_TURNS)
      e->matrix[row][p->joints + i] = e->matrix[p->joints + i][0] / by_motor[0] - p->mount_coupling[i];
  for (i = 0; i < row; i++) e->matrix[i][row] = e->matrix[row][i];
  e->matrix[row][row] = whole;
  e->left[row] = -pull - stiffness * x - damping;
  e->held[row] = 0;
  *loss_W += damping * v;
}

/* inertia and what gravity and speed leave of it, in e->matrix and, taken off, e->left */
static void set_bodies(const tl_effect_dynamics *p, const tl_motion *motion, const tl_link_state *link,
                       double ahead[TL_MAX_JOINTS][3], equations *e, double *loss_W) {
  double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS] = {0.0}, bias[TL_MAX_JOINTS] = {0.0, 0.0};
  double by_motor[TL_MAX_JOINTS]; /* how far the link goes for a unit of what moves it */
  tl_motion now;
  int j, k;

  link_motion(p, motion, link, ahead, &now);
  for (j = 0; j < TL_MAX_JOINTS; j++) by_motor[j] = p->twists[j] ? 1.0 : 1.0 + ahead[j][1];
  tl_inverse(&p->link, &now, bias);
  tl_joint_torque(&p->link, now.q, bias, bias);
  tl_inertia_matrix(&p->link, now.q, matrix);
  e->n = p->joints + p->modes;
  for (j = 0; j < p->joints; j++) {
    e->left[j] -= by_motor[j] * bias[j];
    for (k = 0; k < p->joints; k++)
      e->matrix[j][k] = by_motor[j] * by_motor[k] * matrix[tl_entry(p->joints, j, k)];
  }
  for (k = 0; k < p->modes; k++) set_mode(p, k, &now, link, bias, by_motor, e, loss_W);
}

/* drag between motor and link: known where it slides, else to be found */
static void set_drag(const tl_effect_dynamics *p, int j, const tl_joint_mode *mode, double rate,
                     joint_side *side, equations *e, double *loss_W) {
  double level = p->change[j].drag_Nm;
  int together = level > 0.0 && mode[TL_CONTACT_DRAG + j] == TL_MODE_STICK;

  side->drag = level > 0.0 && !together ? level * (double)mode[TL_CONTACT_DRAG + j] : 0.0;
  side->rests = together && e->held[j];
  side->holds = together && !e->held[j] && mode[j] == TL_MODE_STICK;
  side->joins = together && !e->held[j] && mode[j] != TL_MODE_STICK;
  if (side->holds) e->held[j] = 1;
  e->left[j] += side->drag;
  *loss_W += side->drag * rate;
}

static double clamp(double x, double low, double high) {
  return x < low ? low : x > high ? high : x;
}

/* Where motor and link both rest by friction of their own, drag is not determined: the least that leaves each to its
 * friction, if there is one. What the motor's holds may depend on its load, so the interval is halved. */
static double drag_at_rest(const tl_effect_dynamics *p, int j, const tl_joint_mode *mode, double link_Nm,
                           const joint_side *side) {
  double link = tl_effect_dynamics_link_friction(p, j), low = -link_Nm - link, high = link - link_Nm;
  double least = clamp(0.0, low, high), most, amid = least;
  joint_side tried;
  int i;

  if (mode[j] != TL_MODE_STICK) return side->left / side->gear;
  most = clamp(side->left / side->gear, low, high); /* leaves nothing to the motor's */
  for (i = 0; i < MAX_LOAD_STEPS; i++) {
    tried = *side;
    if (!(fabs(stick(p, j, side->left - amid * side->gear, &tried)) > 1.0)) {
      most = amid;
      if (i == 0) return amid;
    } else {
      least = amid;
    }
    amid = 0.5 * (least + most);
  }
  return most;
}

/* a joint whose transmission twists: its motor's side here and now, its spring for the link */
static void move_motor(const tl_effect_dynamics *p, int j, const tl_joint_mode *mode, const double ahead[3],
                       tl_motion *motion, tl_link_state *link, joint_side *side, equations *e,
                       double *loss_W) {
  const tl_effect_change *c = &p->change[j];
  const tl_drive *d = &p->model->drive[j];
  double turning, speed = motion->v[j] * (1.0 + ahead[1]), rate = speed - link->v[j];
  double torque = tl_spring_torque(&p->spring[j], motion->q[j] + ahead[0] - link->q[j], rate, loss_W);
  double dry = tl_effect_dynamics_link_friction(p, j),
         rub = c->viscous_share * d->viscous_Nms_rad * link->v[j];
  int sticks = dry > 0.0 && mode[TL_CONTACT_LINK + j] == TL_MODE_STICK;

  link->slip[j] = dry > 0.0 && !sticks ? (double)mode[TL_CONTACT_LINK + j] : 0.0;
  rub += dry * link->slip[j];
  *loss_W += rub * link->v[j];
  side->gear = 1.0 + ahead[1];
  side->bend = ahead[2] * motion->v[j] * motion->v[j];
  side->inertia = tl_motor_inertia(p->model, j, c->motor_share, motion, &turning);
  side->left = side->drive - side->torque - side->now.slip * side->level - torque * side->gear - turning;
  e->left[j] = torque - rub - link_offset(p, j);
  e->held[j] = sticks;
  set_drag(p, j, mode, rate, side, e, loss_W);
}

/* the inertia and torque of a motor that drag makes one body with its link */
static void join_motor(const joint_side *side, int j, equations *e) {
  if (!side->joins) return;
  e->matrix[j][j] += side->inertia / (side->gear * side->gear);
  e->left[j] += (side->left + side->inertia * side->bend / side->gear) / side->gear;
}

/* the motor's acceleration, or what holds it, when the link's is known */
static void finish_motor(const tl_effect_dynamics *p, int j, const tl_joint_mode *mode, const equations *e,
                         joint_side *side, tl_motion *motion, tl_link_state *link) {
  double level = p->change[j].drag_Nm, left;

  if (side->rests) side->drag = drag_at_rest(p, j, mode, e->left[j], side);
  if (side->holds) side->drag = -e->left[j];
  if (e->held[j] && !side->holds)
    link->slip[j] = (e->left[j] + (side->rests ? side->drag : 0.0)) / tl_effect_dynamics_link_friction(p, j);
  if (side->joins)
    side->drag = (side->left - side->inertia * (e->a[j] - side->bend) / side->gear) / side->gear;
  left = side->left - side->drag * side->gear;
  motion->a[j] = side->joins ? (e->a[j] - side->bend) / side->gear : left / side->inertia;
  if (mode[j] == TL_MODE_STICK || side->rests) motion->a[j] = 0.0;
  if (mode[j] == TL_MODE_STICK) motion->slip[j] = stick(p, j, left, side);
  link->drag_slip[j] = level > 0.0 ? side->drag / level : 0.0;
  link->drag_a[j] = side->gear * motion->a[j] + side->bend - e->a[j];
}

/* a joint's own side, all that acts on its body but inertia, gravity and the other joint */
static tl_status set_joint(const tl_effect_dynamics *p, int j, double t_s, const tl_joint_mode *mode,
                           double drive_Nm, const double ahead[3], tl_motion *motion, tl_link_state *link,
                           joint_side *side, equations *e, double *loss_W) {
  const tl_effect_change *c = &p->change[j];
  tl_status status;

  side->z = link->z[j];
  status = look_at(p, j, t_s, drive_Nm, mode[j], motion, side);
  if (status != TL_OK) return status;
  motion->slip[j] = side->now.slip;
  *loss_W += (side->torque + side->level * motion->slip[j] + viscous(p, j) * motion->v[j]) * motion->v[j];
  link->z_rate[j] =
      c->memory_Nm > 0.0 ? tl_dahl_rate(motion->v[j], link->z[j], c->travel_rad, c->memory_power) : 0.0;
  e->held[j] = mode[j] == TL_MODE_STICK;
  e->left[j] = side->drive - side->torque - motion->slip[j] * side->level;
  if (p->twists[j]) move_motor(p, j, mode, ahead, motion, link, side, e, loss_W);
  return TL_OK;
}

/* once, with the rotors' torques that motion->a gives */
static tl_status accelerate(const tl_effect_dynamics *p, double t_s, const tl_joint_mode *mode,
                            const double torque[TL_MAX_JOINTS], tl_motion *motion, tl_link_state *link,
                            double *loss_W) {
  double joint[TL_MAX_JOINTS] = {0.0, 0.0}, ahead[TL_MAX_JOINTS][3] = {{0.0}};
  joint_side side[TL_MAX_JOINTS];
  equations e;
  tl_status status;
  int j;

  *loss_W = 0.0;
  memset(&e, 0, sizeof e);
  tl_joint_torque(p->model, motion->q, torque, joint);
  for (j = 0; j < p->joints; j++) {
    tl_effect_dynamics_ahead(p->model, &p->change[j], j, motion->q[j], ahead[j]);
    status = set_joint(p, j, t_s, mode, joint[j], ahead[j], motion, link, &side[j], &e, loss_W);
    if (status != TL_OK) return status;
  }
  set_bodies(p, motion, link, ahead, &e, loss_W);
  for (j = 0; j < p->joints; j++)
    if (p->twists[j]) join_motor(&side[j], j, &e);
  status = solve(&e);
  if (status != TL_OK) return status;
  for (j = 0; j < p->joints; j++) {
    link->a[j] = e.a[j];
    if (p->twists[j]) {
      finish_motor(p, j, mode, &e, &side[j], motion, link);
      continue;
    }
    motion->a[j] = e.a[j];
    if (e.held[j]) motion->slip[j] = stick(p, j, e.left[j], &side[j]);
  }
  for (j = 0; j < p->modes; j++) link->a[TL_MAX_JOINTS + j] = e.a[p->joints + j];
  return TL_OK;
}

/* have the accelerations that friction depends on come to rest? */
static int is_settled(const tl_effect_dynamics *p, const double *before, const double *a) {
  int j;

  for (j = 0; j < p->joints; j++)
    if (p->needs_rotor[j] && fabs(a[j] - before[j]) > ROTOR_TOLERANCE * (1.0 + fabs(a[j]))) return 0;
  return 1;
}

/* to where each of three in a row leads (Aitken) */
static void extrapolate(const tl_effect_dynamics *p, const double *before, const double *next, double *a) {
  int j;

  for (j = 0; j < p->joints; j++) {
    double bend = (a[j] - next[j]) - (next[j] - before[j]);
    if (p->needs_rotor[j] && bend != 0.0) a[j] -= (a[j] - next[j]) * (a[j] - next[j]) / bend;
  }
}

tl_status tl_effect_dynamics_accelerate(const tl_effect_dynamics *p, double t_s, const tl_joint_mode *mode,
                                        const double torque[TL_MAX_JOINTS], tl_motion *motion,
                                        tl_link_state *link, double *loss_W) {
  double before[TL_MAX_JOINTS], next[TL_MAX_JOINTS];
  tl_status status = TL_OK;
  int i;

  if (!p->needs_rotor[0] && !p->needs_rotor[1]) return accelerate(p, t_s, mode, torque, motion, link, loss_W);
  for (i = 0; i < MAX_ROTOR_STEPS && status == TL_OK; i++) {
    memcpy(before, motion->a, sizeof before);
    status = accelerate(p, t_s, mode, torque, motion, link, loss_W);
    if (status == TL_OK && is_settled(p, before, motion->a)) return TL_OK;
    memcpy(next, motion->a, sizeof next);
    if (status == TL_OK) status = accelerate(p, t_s, mode, torque, motion, link, loss_W);
    extrapolate(p, before, next, motion->a);
  }
  return status == TL_OK ? TL_ERR_NO_CONVERGENCE : status;
}
