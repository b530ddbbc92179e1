/* feed.c: see feed.h. */
#include "feed.h"

#include <math.h>
#include <string.h>

#define SPEED_HZ 100.0 /* of the low-pass on the measured speed, first order */

static const double pi = 3.14159265358979323846;

void feed_init(struct feed *f, const struct model_file *file, const struct controller *controller,
               const struct trajectory *motion, double speed_lag_s) {
  memset(f, 0, sizeof *f);
  f->file = file;
  f->controller = controller;
  f->motion = motion;
  f->speed_lag_s = speed_lag_s;
  tl_controller_start_f64(&f->state);
  for (int j = 0; j < TL_CONTROLLER_JOINTS && file; j++)
    leg_bus_encoder_init(&f->encoder[j], &file->model, &file->bus, j);
}

/* Angle from the motor's encoder, speed from its change over so many ticks, low-passed. */
static void measure(struct feed *f, int joint, double since_s, int first) {
  const tl_transmission *t = &f->file->model.drive[joint].transmission;
  tl_controller_frame_f64 *seen = &f->in.measured;
  const double angle = tl_transmission_joint_angle(t, f->encoder[joint].motor_rad);
  const double share = 1.0 - exp(-2.0 * pi * SPEED_HZ * since_s);

  if (!first)
    seen->speed_rad_s[joint] +=
        share * ((angle - seen->angle_rad[joint]) / since_s - seen->speed_rad_s[joint]);
  seen->angle_rad[joint] = angle;
}

void feed_take(struct feed *f, const struct leg_bus_frame *frame) {
  struct leg_bus_state state;
  int joint;

  if (leg_bus_is_stop(frame)) f->stopped = 1;
  if (!f->controller || leg_bus_unpack_state(frame, &joint, &state) != 0) return;
  leg_bus_encoder_take(&f->encoder[joint], &state);
  f->counter[joint] = state.counter;
  f->came[joint] = 1;
  if (!f->came[0] || !f->came[1] || f->counter[0] != f->counter[1]) return;
  /* both of one tick: a measured frame, unless it is repeated or older */
  const int first = f->frames == 0, step = first ? 1 : (int16_t)(uint16_t)(state.counter - f->last_counter);
  if (step <= 0) return;
  f->in.measured.count += (uint32_t)step;
  for (int j = 0; j < TL_CONTROLLER_JOINTS; j++) measure(f, j, step * f->controller->settings.tick_s, first);
  f->last_counter = state.counter;
  f->frames++;
}

/* the controller's call; the torque is held for a tick, so it is that of the tick's middle */
static void feed_forward(struct feed *f, double t_s, int enable, double torque_Nm[TL_CONTROLLER_JOINTS]) {
  tl_motion desired;

  trajectory_at(f->motion, t_s + 0.5 * f->controller->settings.tick_s, &desired);
  for (int j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    f->in.desired.angle_rad[j] = desired.q[j];
    f->in.desired.speed_rad_s[j] = desired.v[j];
    f->in.desired.acceleration[j] = desired.a[j];
  }
  f->in.desired.count++;
  f->in.enable = enable && !f->stopped;
  tl_controller_tick_f64(&f->controller->f64, &f->state, &f->in, &f->out);
  for (int j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    torque_Nm[j] = f->out.torque_Nm[j];
    f->peak_Nm[j] = fmax(f->peak_Nm[j], fabs(torque_Nm[j]));
  }
  for (int bit = 0; bit < FEED_STATUS_BITS; bit++) f->told[bit] += f->out.status >> bit & 1U;
}

void feed_tick(struct feed *f, double t_s, int enable, tl_motion *setpoint,
               double torque_Nm[TL_CONTROLLER_JOINTS]) {
  tl_motion late;

  trajectory_at(f->motion, t_s, setpoint);
  trajectory_at(f->motion, t_s - f->speed_lag_s, &late);
  memcpy(setpoint->v, late.v, sizeof late.v);
  memset(torque_Nm, 0, TL_CONTROLLER_JOINTS * sizeof *torque_Nm);
  if (f->controller) feed_forward(f, t_s, enable, torque_Nm);
  f->ticks++;
}

const char *feed_status_name(int bit) {
  static const char *const name[FEED_STATUS_BITS] = {
      "stale desired", "stale measured", "impossible",   "jump",       "frozen",      "stopped",
      "decaying",      "zero",           "torque limit", "rate limit", "power limit", "joint limit"};

  return name[bit];
}
