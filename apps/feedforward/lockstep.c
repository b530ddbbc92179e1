/* lockstep.c: see lockstep.h. */
#include "lockstep.h"

#include <math.h>
#include <string.h>

#include "leg_bus/orders.h"
#include "leg_bus/twin_states.h"
#include "talus/experimental/twin.h"

enum { JOINTS = TL_CONTROLLER_JOINTS };

struct bench {
  const struct lockstep *asked;
  tl_excitation excitation;
  tl_twin_settings settings;
  tl_limits limits[TL_MAX_JOINTS];
  struct orders orders;
  tl_twin twin;
  struct feed feed;
};

/* ---- before ------------------------------------------------------------------------ */

static tl_status build(struct bench *b) {
  const struct model_file *truth = b->asked->truth;

  orders_rest(&b->excitation, JOINTS);
  b->settings = tl_twin_defaults(&truth->model, &b->excitation);
  twin_states_settings(&truth->bus, &b->settings);
  b->settings.seed = b->asked->seed;
  b->settings.effect = truth->effect;
  b->settings.effects = truth->effects;
  tl_twin_limits(&truth->model, &b->settings, b->limits);
  orders_init(&b->orders, &truth->model, &b->settings, b->limits, 1);
  return tl_twin_init(&b->twin, &truth->model, &b->excitation, &b->settings);
}

/* ---- a tick ------------------------------------------------------------------------ */

/* set-points and torques as the bench reads them from their frames */
static int command(struct bench *b, uint16_t counter, const tl_motion *to, const double torque_Nm[JOINTS]) {
  struct leg_bus_frame frame;

  for (int j = 0; j < JOINTS; j++) {
    memset(&frame, 0, sizeof frame);
    if (leg_bus_command(&frame, j, counter, to->q[j], to->v[j], torque_Nm[j]) != 0) return -1;
    orders_take(&b->orders, &frame);
  }
  return 0;
}

/* what the drives measured, as frames */
static void measure(struct bench *b, uint16_t counter, const double row[TL_CHANNEL_COUNT]) {
  static const double zero_count[TL_MAX_JOINTS];
  struct leg_bus_frame frame[TL_MAX_JOINTS];

  twin_states_pack(&b->twin, &b->asked->truth->bus, counter, row, zero_count, frame);
  for (int j = 0; j < JOINTS; j++) feed_take(&b->feed, &frame[j]);
}

/* sums of squares; the drive's torque less what the set-point brought is its feedback */
static void score(const struct bench *b, double t_s, struct lockstep_result *r) {
  tl_motion wanted, joints;

  trajectory_at(b->asked->motion, t_s, &wanted);
  tl_simulation_joints(b->twin.model, &b->twin.simulation, &joints);
  for (int j = 0; j < JOINTS; j++) {
    struct lockstep_joint *to = &r->joint[j];
    const double constant = b->asked->truth->model.drive[j].torque_constant_Nm_A;
    const double given = b->orders.last[j].torque_Nm, total = b->twin.current_A[j] * constant;

    to->error_rad += pow(wanted.q[j] - joints.q[j], 2.0);
    to->feedback_Nm += pow(total - given, 2.0);
    to->feedforward_Nm += given * given;
    to->total_Nm += total * total;
  }
  r->ticks++;
}

/* the same tick for who looks on */
static void show(const struct bench *b, double t_s) {
  const tl_controller_parts_f64 *parts = &b->feed.out.parts;
  struct lockstep_instant at = {.t_s = t_s};
  tl_motion wanted, joints;

  trajectory_at(b->asked->motion, t_s, &wanted);
  tl_simulation_joints(b->twin.model, &b->twin.simulation, &joints);
  for (int j = 0; j < JOINTS; j++) {
    const double given = b->orders.last[j].torque_Nm;
    const double total = b->twin.current_A[j] * b->asked->truth->model.drive[j].torque_constant_Nm_A;

    at.joint[j] = (struct lockstep_joint_instant){.desired_rad = wanted.q[j],
                                                  .measured_rad = b->feed.in.measured.angle_rad[j],
                                                  .error_rad = wanted.q[j] - joints.q[j],
                                                  .feedforward_Nm = given,
                                                  .feedback_Nm = total - given,
                                                  .inertia_Nm = parts->inertia_Nm[j],
                                                  .gravity_Nm = parts->gravity_Nm[j],
                                                  .friction_Nm = parts->friction_Nm[j],
                                                  .effects_Nm = parts->effects_Nm[j]};
  }
  b->asked->see(b->asked->context, &at);
}

/* over every tick, in the motion and beside it */
static void watch(const struct bench *b, struct lockstep_result *r) {
  for (int j = 0; j < JOINTS; j++) {
    struct lockstep_joint *to = &r->joint[j];
    const double constant = b->asked->truth->model.drive[j].torque_constant_Nm_A;

    to->peak_A = fmax(to->peak_A, fabs(b->twin.current_A[j]));
    to->limited += fabs(b->twin.current_A[j]) >= b->settings.current_limit_A[j];
    to->feedforward_peak_A = fmax(to->feedforward_peak_A, fabs(b->orders.last[j].torque_Nm) / constant);
  }
}

static tl_status tick(struct bench *b, unsigned long k, struct lockstep_result *r) {
  const double now_s = (double)k / b->settings.control_hz, t_s = now_s - LOCKSTEP_LEAD_S;
  double torque_Nm[JOINTS] = {0.0, 0.0}, row[TL_CHANNEL_COUNT];
  tl_status status;
  tl_motion to;

  feed_tick(&b->feed, t_s, 1, &to, torque_Nm);
  if (command(b, (uint16_t)k, &to, torque_Nm) != 0) return TL_ERR_RANGE;
  orders_apply(&b->orders, now_s, &b->excitation, &b->twin);
  status = tl_twin_next(&b->twin, row);
  if (status != TL_OK) return status;
  measure(b, (uint16_t)k, row);
  watch(b, r);
  if (t_s >= 0.0 && t_s < trajectory_length_s(b->asked->motion)) {
    score(b, row[TL_CHANNEL_TIME] - LOCKSTEP_LEAD_S, r);
    if (b->asked->see) show(b, row[TL_CHANNEL_TIME] - LOCKSTEP_LEAD_S);
  }
  return TL_OK;
}

/* ---- a run ------------------------------------------------------------------------- */

static void conclude(const struct bench *b, const struct controller *controller, struct lockstep_result *r) {
  for (int j = 0; j < JOINTS; j++) {
    struct lockstep_joint *to = &r->joint[j];

    to->error_rad = sqrt(to->error_rad / (double)r->ticks);
    to->feedback_Nm = sqrt(to->feedback_Nm / (double)r->ticks);
    to->feedforward_Nm = sqrt(to->feedforward_Nm / (double)r->ticks);
    to->total_Nm = sqrt(to->total_Nm / (double)r->ticks);
    to->share = to->feedback_Nm / to->total_Nm;
    to->limit_A = b->settings.current_limit_A[j];
    to->feedforward_limit_A = controller ? controller->settings.joint[j].current_limit_A : 0.0;
  }
  memcpy(r->told, b->feed.told, sizeof r->told);
}

int lockstep_run(const struct lockstep *l, const struct model_file *file, const struct controller *controller,
                 struct lockstep_result *result, struct app_error *error) {
  const double length_s = trajectory_length_s(l->motion) + 2.0 * LOCKSTEP_LEAD_S;
  struct bench b = {.asked = l};
  tl_status status = build(&b);

  memset(result, 0, sizeof *result);
  if (status != TL_OK)
    return app_fail(error, APP_BAD_INPUT, "the bench cannot be built: %s", tl_status_text(status));
  feed_init(&b.feed, file, controller, l->motion, l->speed_lag_s);
  for (unsigned long k = 0; status == TL_OK && (double)k < length_s * b.settings.control_hz; k++)
    status = tick(&b, k, result);
  if (b.orders.clamped)
    return app_fail(error, APP_BAD_INPUT, "%s: a set-point is beyond what the bench's joints reach",
                    l->motion->path);
  if (status != TL_OK)
    return app_fail(error, APP_FAILED, "the simulation ended after %.3f s: %s", b.twin.simulation.t_s,
                    tl_status_text(status));
  conclude(&b, controller, result);
  return 0;
}
