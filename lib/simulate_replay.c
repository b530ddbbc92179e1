/* simulate_replay.c: a recorded motion driven once more under a model; see talus/experimental/simulate.h. */
#include <math.h>

#include "talus/experimental/simulate.h"
#include "talus/math.h"

#define TWO_PI 6.283185307179586
#define FARTHEST 1e6 /* rad or m: beyond it the loop has not held the plant */

/* what drives the plant between two rows */
typedef struct drive_between {
  const tl_replay *replay;
  size_t row;
  double gain[TL_MAX_JOINTS];                              /* d torque / d acceleration at the row */
  double position[TL_MAX_JOINTS], velocity[TL_MAX_JOINTS]; /* that a drive's loop has seen */
  double share[TL_MAX_JOINTS]; /* of each change, that the low-pass on its speed lets through at a tick */
  double held[TL_MAX_JOINTS];  /* its torque since its last tick */
  size_t ticks;                /* so many of them */
} drive_between;

/* straight between two rows */
static double between(const double *x, size_t row, double share) {
  return x[row] + share * (x[row + 1] - x[row]);
}

static void driven(const void *context, double t_s, const tl_motion *motion, double torque[TL_MAX_JOINTS]) {
  const drive_between *d = (const drive_between *)context;
  const tl_replay *r = d->replay;
  double share = (t_s - (r->t_s[d->row] - r->t_s[0])) / (r->t_s[d->row + 1] - r->t_s[d->row]);
  double w = TWO_PI * r->loop_hz;
  int j;

  for (j = 0; j < TL_MAX_JOINTS; j++) {
    torque[j] = d->held[j];
    if (!r->q[j] || r->loop[j].order) continue;
    torque[j] = between(r->torque[j], d->row, share) +
                d->gain[j] * (w * w * (between(r->q[j], d->row, share) - motion->q[j]) +
                              2.0 * w * (between(r->v[j], d->row, share) - motion->v[j]));
  }
}

/* d torque / d acceleration of each joint where the plant stands: the inverse dynamics are linear in it */
static void gains(const tl_model *m, const tl_motion *at, int joints, double gain[TL_MAX_JOINTS]) {
  double still[TL_MAX_JOINTS], moved[TL_MAX_JOINTS];
  int j, k;

  for (j = 0; j < joints; j++) {
    tl_motion now = *at;
    for (k = 0; k < joints; k++) now.a[k] = 0.0;
    tl_inverse(m, &now, still);
    now.a[j] = 1.0;
    tl_inverse(m, &now, moved);
    gain[j] = moved[j] - still[j];
  }
}

/* where a drive's encoder shows a joint */
static double seen_at(const tl_replay *r, int joint, double q) {
  const tl_replay_loop *loop = &r->loop[joint];

  return tl_loop_grid(tl_drive_position(r->model, joint, q) - loop->offset, loop->step) + loop->offset;
}

/* one tick of the drives' loops, where the plant stands */
static void tick(const tl_replay *r, const tl_simulation *s, drive_between *d, int joints) {
  int j;

  for (j = 0; j < joints; j++) {
    const tl_replay_loop *loop = &r->loop[j];
    double seen, velocity;
    if (!loop->order) continue;
    seen = seen_at(r, j, s->motion.q[j]);
    velocity = tl_loop_speed(seen, 1.0 / r->longest_step_s, d->share[j], &d->position[j], &d->velocity[j]);
    d->held[j] = loop->order[d->ticks] - loop->stiffness * seen - loop->damping * velocity;
  }
  d->ticks++;
}

/* the plant to the next row, through the ticks that come before it */
static tl_status run_to_row(const tl_replay *r, tl_simulation *s, drive_between *d, int joints) {
  double until = r->t_s[d->row + 1] - r->t_s[0], at;
  tl_status status = TL_OK;

  while (status == TL_OK && d->ticks < r->ticks &&
         (at = r->first_tick_s + (double)d->ticks * r->longest_step_s) < until) {
    status = tl_simulate(r->model, driven, d, r->longest_step_s, s, at);
    if (status == TL_OK) tick(r, s, d, joints);
  }
  return status == TL_OK ? tl_simulate(r->model, driven, d, r->longest_step_s, s, until) : status;
}

/* writes where the plant stands to a row; 0 where it has left the recorded motion altogether */
static int shown(const tl_replay *r, const tl_simulation *s, const drive_between *d, size_t row, int joints) {
  double torque[TL_MAX_JOINTS] = {0.0, 0.0};
  tl_motion seen;
  int j;

  tl_simulation_joints(r->model, s, &seen);
  driven(d, r->t_s[row] - r->t_s[0], &s->motion, torque);
  for (j = 0; j < joints && j < TL_MAX_JOINTS; j++) {
    r->q_out[j][row] = s->motion.q[j];
    r->v_out[j][row] = s->motion.v[j];
    r->joint_out[j][row] = seen.q[j];
    r->torque_out[j][row] = torque[j];
    if (!(fabs(s->motion.q[j] - r->q[j][row]) < FARTHEST)) return 0;
  }
  return 1;
}

/* the plant and the loops at row 0 */
static tl_status begin(const tl_replay *r, tl_simulation *s, drive_between *d, int joints) {
  double q[TL_MAX_JOINTS] = {0.0, 0.0}, v[TL_MAX_JOINTS] = {0.0, 0.0};
  tl_status status;
  int j;

  for (j = 0; j < joints; j++) {
    q[j] = r->q[j][0];
    v[j] = r->v[j][0];
  }
  status = tl_simulation_init(s, r->model, q, v);
  s->effect = r->effect;
  s->effects = r->effects;
  for (j = 0; j < joints && status == TL_OK; j++) {
    d->position[j] = seen_at(r, j, q[j]);
    d->velocity[j] = v[j] * tl_drive_ratio(r->model, j, q[j]);
    d->share[j] = 1.0 - tl_exp(-TWO_PI * r->loop[j].velocity_hz * r->longest_step_s);
  }
  if (status == TL_OK && r->ticks > 0) tick(r, s, d, joints);
  return status;
}

tl_status tl_simulate_replay(const tl_replay *r) {
  tl_simulation s;
  drive_between d = {.replay = r};
  tl_status status;
  size_t row;
  int joints;

  if (!r || !r->model || r->n < 2 || !(r->longest_step_s > 0.0) || !(r->loop_hz >= 0.0) ||
      !(r->first_tick_s > -r->longest_step_s && r->first_tick_s <= 0.0))
    return TL_ERR_ARGUMENT;
  joints = tl_joint_count(r->model);
  status = begin(r, &s, &d, joints);
  if (status != TL_OK) return status;
  gains(r->model, &s.motion, joints, d.gain);
  if (!shown(r, &s, &d, 0, joints)) return TL_ERR_NOT_FINITE;
  for (row = 1; row < r->n; row++) {
    status = run_to_row(r, &s, &d, joints);
    if (status != TL_OK) return status;
    if (!shown(r, &s, &d, row, joints)) return TL_ERR_NOT_FINITE;
    d.row = row;
    gains(r->model, &s.motion, joints, d.gain);
  }
  return TL_OK;
}
