/* fixed_point.c: every call of the fixed-point routines with every argument, for Frama-C's Eva to look for overflows, undefined shifts
 * and reads outside a table (tests/test_proof.py).
 *
 * A controller holds any numbers but for what tl_controller_to_q31 sees to: the model's within 2^29, torque limits not negative, tables of 2 to 129
 * knots of any value, 0 to 99 stale_ticks, 2 to 100 decay_ticks, 1 to 1000 recover_ticks. A state holds any frames and
 * torques, and counts such as a tick leaves them.
 */
#include "__fc_builtin.h"
#include "talus/controller.h"

#define MOST (1 << 29)

static tl_curve_knot_q31 knot[TL_CURVE_MAX_KNOTS];

static int32_t any(void) {
  return Frama_C_interval(INT32_MIN, INT32_MAX);
}

static uint32_t any_unsigned(void) {
  return Frama_C_unsigned_int_interval(0, UINT32_MAX);
}

static tl_curve_q31 any_curve(int least) {
  tl_curve_q31 c = {knot,           Frama_C_interval(least, TL_CURVE_MAX_KNOTS),
                    any(),          any_unsigned(),
                    any_unsigned(), any_unsigned()};

  return c;
}

static tl_controller_joint_q31 any_joint(void) {
  tl_controller_joint_q31 j;

  Frama_C_make_unknown((char *)&j, sizeof j);
  j.ratio = j.inverse = j.slow = j.fast = j.spring = j.position = j.droop = any_curve(2);
  j.torque_limit_Nm = Frama_C_interval(0, INT32_MAX);
  j.viscous = Frama_C_interval(-MOST, MOST);
  j.viscous_asymmetry = Frama_C_interval(-MOST, MOST);
  return j;
}

static tl_controller_q31 any_controller(void) {
  tl_controller_q31 c;

  c.joint[0] = any_joint();
  c.joint[1] = any_joint();
  c.shank_inertia = c.foot_inertia = c.coupling = c.rotor = Frama_C_interval(-MOST, MOST);
  c.gravity_shank = c.gravity_foot = c.tilt_shank = c.tilt_foot = Frama_C_interval(-MOST, MOST);
  c.tilted = any();
  c.per_level = Frama_C_interval(-MOST, MOST);
  c.stale_ticks = Frama_C_interval(0, 99);
  c.decay_ticks = Frama_C_interval(2, 100);
  c.recover_ticks = Frama_C_interval(1, TL_CONTROLLER_MOST_TICKS);
  return c;
}

static void ticks(void) {
  tl_controller_q31 c = any_controller();
  tl_controller_state_q31 s;
  tl_controller_input_q31 in;
  tl_controller_output_q31 out;
  tl_controller_parts_q31 parts;
  int32_t torque[2];
  uint32_t saturated = 0;

  Frama_C_make_unknown((char *)&in, sizeof in);
  tl_controller_torque_q31(&c, &in.desired, torque, &parts, &saturated);
  tl_controller_start_q31(&s);
  Frama_C_make_unknown((char *)&s.desired, sizeof s.desired);
  Frama_C_make_unknown((char *)&s.measured, sizeof s.measured);
  s.torque_Nm[0] = s.torque_Nm[1] = any();
  s.desired_age = s.measured_age = Frama_C_interval(0, TL_CONTROLLER_MOST_TICKS);
  s.still[0] = s.still[1] = Frama_C_interval(0, 100);
  s.level = Frama_C_interval(0, 100);
  s.good = Frama_C_interval(0, TL_CONTROLLER_MOST_TICKS);
  s.begun = Frama_C_interval(0, 3);
  tl_controller_tick_q31(&c, &s, &in, &out);
}

int main(void) {
  uint32_t saturated = 0;
  tl_curve_q31 curve;
  int32_t sine, cosine, slope;

  Frama_C_make_unknown((char *)knot, sizeof knot);
  curve = any_curve(2);
  (void)tl_fixed_saturate(Frama_C_long_long_interval(INT64_MIN, INT64_MAX), &saturated);
  (void)tl_fixed_multiply(any(), any(), Frama_C_interval(1, 62), &saturated);
  tl_fixed_sincos(any(), &sine, &cosine);
  (void)tl_curve_at_q31(&curve, any(), &slope, &saturated);
  ticks();
  return 0;
}
