/* leg_tick_f32.c: the tick in float, for a processor with a floating-point unit. */
#include "leg.h"
#include "leg_tick.h"

#define RAD_PER_COUNT 9.58737992e-5f /* 2 pi / 65536 */

static tl_controller_state_f32 state;

void leg_start(void) {
  tl_controller_start_f32(&state);
}

static void frame(const int32_t *angle, const int32_t *speed, const int32_t *acceleration, uint32_t counter,
                  tl_controller_frame_f32 *to) {
  int j;

  for (j = 0; j < 2; j++) {
    to->angle_rad[j] = (float)angle[j] * RAD_PER_COUNT;
    to->speed_rad_s[j] = (float)speed[j] * RAD_PER_COUNT;
    to->acceleration[j] = acceleration ? (float)acceleration[j] * RAD_PER_COUNT : 0.0f;
  }
  to->count = counter;
}

uint32_t leg_tick(const struct leg_counts *in, int32_t current_mA[2]) {
  tl_controller_input_f32 now;
  tl_controller_output_f32 out;
  int j;

  frame(in->desired_count, in->desired_speed_count_s, in->desired_acceleration_count_s2, in->desired_counter,
        &now.desired);
  frame(in->joint_count, in->speed_count_s, 0, in->measured_counter, &now.measured);
  now.enable = in->enable;
  tl_controller_tick_f32(&leg_f32, &state, &now, &out);
  for (j = 0; j < 2; j++) current_mA[j] = (int32_t)(out.current_A[j] * 1000.0f);
  return out.status;
}
