/* controller_prepare_copy.c: a controller in float and in fixed point, from the one in double. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "controller_prepare_internal.h"

#define FIELD(type, name, count, q)                                                                          \
  { #name, offsetof(type##_f64, name), offsetof(type##_f32, name), offsetof(type##_q31, name), count, q }
#define JOINT(name, count, q) FIELD(tl_controller_joint, name, count, q)
#define LEG(name, q) FIELD(tl_controller, name, 1, q)

static const tl_controller_field joint_field[] = {
    JOINT(inverse_scale, 1, 31),
    JOINT(slope_per_rad, 1, 24),
    JOINT(friction_gain, 1, 20),
    JOINT(dry_Nm, 1, 21),
    JOINT(speed_scale, 1, 21),
    JOINT(asymmetry_Nm, 1, 21),
    JOINT(viscous, 1, 23),
    JOINT(viscous_asymmetry, 1, 23),
    JOINT(load_even, 1, 30),
    JOINT(load_odd, 1, 30),
    JOINT(spring_scale, 1, 21),
    JOINT(position_scale, 1, 21),
    JOINT(slow_rad_s, 1, 25),
    JOINT(torque_limit_Nm, 1, 26),
    JOINT(rate_Nm, 1, 26),
    JOINT(power_Nm, TL_POWER_LINES, 26),
    JOINT(power_slope, TL_POWER_LINES, 23),
    JOINT(low_rad, 1, 29),
    JOINT(high_rad, 1, 29),
    JOINT(fade_gain, 1, 22),
    JOINT(middle_rad, 1, 29),
    JOINT(reach_rad, 1, 29),
    JOINT(speed_limit_rad_s, 1, 25),
    JOINT(acceleration_limit, 1, 19),
    JOINT(angle_step_rad, 1, 29),
    JOINT(angle_slack_rad, 1, 29),
    JOINT(speed_step_rad_s, 1, 25),
    JOINT(frozen_rad_s, 1, 25),
    JOINT(amperes_per_Nm, 1, 20),
    JOINT(offset_Nm, 1, 26),
    JOINT(droop_scale, 1, 26),
};
static const tl_controller_field leg_field[] = {
    LEG(shank_inertia, 27), LEG(foot_inertia, 27),  LEG(coupling, 27),
    LEG(rotor, 27),         LEG(gravity_shank, 21), LEG(gravity_foot, 21),
    LEG(tilt_shank, 21),    LEG(tilt_foot, 21),     LEG(per_level, 30),
};

static const tl_controller_field curve_field[] = {
    JOINT(ratio, 1, TL_Q_ANGLE),        JOINT(inverse, 1, TL_Q_ANGLE), JOINT(slow, 1, TL_Q_SPEED),
    JOINT(fast, 1, TL_Q_SPEED),         JOINT(spring, 1, TL_Q_ANGLE),  JOINT(position, 1, TL_Q_ANGLE),
    JOINT(droop, 1, TL_Q_MOTOR_TORQUE),
};
#define COUNT(array) (sizeof(array) / sizeof(array)[0])

const tl_controller_field *tl_controller_fields(int *n) {
  *n = (int)COUNT(leg_field);
  return leg_field;
}

const tl_controller_field *tl_controller_joint_fields(int *n) {
  *n = (int)COUNT(joint_field);
  return joint_field;
}

const tl_controller_field *tl_controller_curves(int *n) {
  *n = (int)COUNT(curve_field);
  return curve_field;
}

static const double *double_at(const void *from, size_t offset) {
  return (const double *)(const void *)((const char *)from + offset);
}

static const tl_curve_f64 *curve_at(const tl_controller_joint_f64 *joint, size_t offset) {
  return (const tl_curve_f64 *)(const void *)((const char *)joint + offset);
}

int tl_controller_knots(const tl_controller_f64 *c) {
  int sum = 0, j;
  size_t i;

  for (j = 0; j < TL_CONTROLLER_JOINTS; j++)
    for (i = 0; i < COUNT(curve_field); i++) sum += curve_at(&c->joint[j], curve_field[i].f64)->n;
  return sum;
}

/* ---- float -------------------------------------------------------------------------- */

static void floats(const tl_controller_field *f, size_t n, const void *from, void *to) {
  size_t i;
  int k;

  for (i = 0; i < n; i++)
    for (k = 0; k < f[i].count; k++)
      ((float *)(void *)((char *)to + f[i].f32))[k] = (float)double_at(from, f[i].f64)[k];
}

void tl_controller_to_f32(const tl_controller_f64 *c, tl_curve_knot_f32 *knot, tl_controller_f32 *out) {
  size_t i;
  int j;

  memset(out, 0, sizeof *out);
  out->tilted = c->tilted;
  out->stale_ticks = c->stale_ticks;
  out->decay_ticks = c->decay_ticks;
  out->recover_ticks = c->recover_ticks;
  floats(leg_field, COUNT(leg_field), c, out);
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    floats(joint_field, COUNT(joint_field), &c->joint[j], &out->joint[j]);
    out->joint[j].side = c->joint[j].side;
    out->joint[j].uses = c->joint[j].uses;
    for (i = 0; i < COUNT(curve_field); i++) {
      const tl_curve_f64 *from = curve_at(&c->joint[j], curve_field[i].f64);
      tl_curve_f32 *to = (tl_curve_f32 *)(void *)((char *)&out->joint[j] + curve_field[i].f32);

      if (!from->n) continue;
      tl_curve_to_f32(from, knot, to);
      knot += from->n;
    }
  }
}

/* ---- fixed point ---------------------------------------------------------------------- */

static void whole(const tl_controller_field *f, size_t n, const void *from, void *to, uint32_t *saturated) {
  size_t i;
  int k;

  for (i = 0; i < n; i++)
    for (k = 0; k < f[i].count; k++) {
      int32_t *place = (int32_t *)(void *)((char *)to + f[i].q31) + k;
      *place = tl_fixed_from_double(double_at(from, f[i].f64)[k], f[i].q, saturated);
    }
}

static tl_status whole_curves(const tl_controller_joint_f64 *from, tl_curve_knot_q31 **knot,
                              tl_controller_joint_q31 *to) {
  size_t i;

  for (i = 0; i < COUNT(curve_field); i++) {
    const tl_curve_f64 *curve = curve_at(from, curve_field[i].f64);
    tl_status status = TL_OK;

    if (curve->n)
      status = tl_curve_to_q31(curve, curve_field[i].q, *knot,
                               (tl_curve_q31 *)(void *)((char *)to + curve_field[i].q31));
    if (status != TL_OK) return status;
    *knot += curve->n;
  }
  return TL_OK;
}

/* The largest sums within the limits, against the formats' ends. A curve is at most 1, the slope of a ratio's curve at most
 * 1.5 / 12 a step. */
static int sums_fit(const tl_controller_f64 *c) {
  const tl_controller_joint_f64 *k = &c->joint[0], *n = &c->joint[1];
  double a0 = k->acceleration_limit, a1 = n->acceleration_limit, v0 = k->speed_limit_rad_s,
         v1 = n->speed_limit_rad_s;
  double foot = a0 + a1, knee = a0 + foot + 2.0 * v0 * v1 + v1 * v1, ankle = a0 + v0 * v0;
  double turned = a1 + 1.5 * TL_CURVE_STEEPEST * n->slope_per_rad * v1 * v1, load[2];
  int j;

  if (!(knee < 4096.0 && ankle < 4096.0 && turned < 4096.0 &&
        1.5 * TL_CURVE_STEEPEST * n->slope_per_rad < 16.0))
    return 0;
  load[0] = c->shank_inertia * a0 + c->foot_inertia * foot + c->coupling * knee + c->gravity_shank +
            c->gravity_foot;
  load[1] = c->foot_inertia * foot + c->coupling * ankle + c->gravity_foot + c->rotor * turned;
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    const tl_controller_joint_f64 *d = &c->joint[j];
    double v = d->speed_limit_rad_s;
    double friction = d->dry_Nm + fabs(d->speed_scale) + fabs(d->position_scale) + fabs(d->asymmetry_Nm) +
                      (fabs(d->load_even) + fabs(d->load_odd)) * load[j] +
                      (d->viscous + fabs(d->viscous_asymmetry)) * v;
    double sum = load[j] + friction + fabs(d->spring_scale) + fabs(c->tilt_shank) + fabs(c->tilt_foot);

    if (!(sum < 1024.0 && sum * fabs(d->inverse_scale) < 32.0)) return 0;
    if (!((d->torque_limit_Nm + fabs(d->offset_Nm) + fabs(d->droop_scale)) * d->amperes_per_Nm < 2048.0))
      return 0;
  }
  return 1;
}

/* what a frame may differ from the last after stale_ticks: sums that a tick makes without looking at their range */
static int ticks_fit(const tl_controller_f64 *c) {
  double ticks = (double)(c->stale_ticks + 1);
  int j;

  for (j = 0; j < TL_CONTROLLER_JOINTS; j++)
    if (!(c->joint[j].angle_step_rad * ticks + c->joint[j].angle_slack_rad < 3.99) ||
        !(c->joint[j].speed_step_rad_s * ticks < 63.9))
      return 0;
  return 1;
}

/* controller_template.h adds up their products: 2 bits to spare */
static int has_room(const tl_controller_q31 *c) {
  const int32_t most = (int32_t)1 << 29;
  size_t i;
  int j;

  for (i = 0; i < COUNT(leg_field); i++) {
    int32_t x = *(const int32_t *)(const void *)((const char *)c + leg_field[i].q31);
    if (x > most || x < -most) return 0;
  }
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    int32_t asymmetry = c->joint[j].viscous_asymmetry;
    if (c->joint[j].viscous > most || asymmetry > most || asymmetry < -most) return 0;
  }
  return 1;
}

tl_status tl_controller_to_q31(const tl_controller_f64 *c, tl_curve_knot_q31 *knot, tl_controller_q31 *out) {
  tl_controller_q31 made;
  uint32_t saturated = 0;
  int j;

  memset(&made, 0, sizeof made);
  made.tilted = c->tilted;
  made.stale_ticks = c->stale_ticks;
  made.decay_ticks = c->decay_ticks;
  made.recover_ticks = c->recover_ticks;
  whole(leg_field, COUNT(leg_field), c, &made, &saturated);
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    tl_status status = whole_curves(&c->joint[j], &knot, &made.joint[j]);

    if (status != TL_OK) return status;
    whole(joint_field, COUNT(joint_field), &c->joint[j], &made.joint[j], &saturated);
    made.joint[j].side = c->joint[j].side;
    made.joint[j].uses = c->joint[j].uses;
  }
  if (saturated || !sums_fit(c) || !ticks_fit(c) || !has_room(&made)) return TL_ERR_RANGE;
  *out = made;
  return TL_OK;
}
