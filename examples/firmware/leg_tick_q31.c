/* leg_tick_q31.c: the tick in fixed point, for a processor without floating point. */
#include "leg.h"
#include "leg_tick.h"

#define RAD_Q44 1686629713 /* 2 pi / 65536 in Q44: count times it, over 2^15, is Q29 */

static tl_controller_state_q31 state;

void leg_start(void) {
  tl_controller_start_q31(&state);
}

/* counts in Q0 times Q44 to the quantity's format */
static void frame(const int32_t *angle, const int32_t *speed, const int32_t *acceleration, uint32_t counter,
                  tl_controller_frame_q31 *to) {
  uint32_t saturated = 0;
  int j;

  for (j = 0; j < 2; j++) {
    to->angle_rad[j] = tl_fixed_multiply(angle[j], RAD_Q44, 44 - TL_Q_ANGLE, &saturated);
    to->speed_rad_s[j] = tl_fixed_multiply(speed[j], RAD_Q44, 44 - TL_Q_SPEED, &saturated);
    to->acceleration[j] =
        acceleration ? tl_fixed_multiply(acceleration[j], RAD_Q44, 44 - TL_Q_ACCELERATION, &saturated) : 0;
  }
  to->count = counter;
}

uint32_t leg_tick(const struct leg_counts *in, int32_t current_mA[2]) {
  tl_controller_input_q31 now;
  tl_controller_output_q31 out;
  uint32_t saturated = 0;
  int j;

  frame(in->desired_count, in->desired_speed_count_s, in->desired_acceleration_count_s2, in->desired_counter,
        &now.desired);
  frame(in->joint_count, in->speed_count_s, 0, in->measured_counter, &now.measured);
  now.enable = in->enable;
  tl_controller_tick_q31(&leg_q31, &state, &now, &out);
  for (j = 0; j < 2; j++) current_mA[j] = tl_fixed_multiply(out.current_A[j], 1000, TL_Q_CURRENT, &saturated);
  return out.status;
}
