/* leg_tick.h: the body of a 1 kHz timer interrupt: encoder counts in, currents out. */
#ifndef LEG_TICK_H
#define LEG_TICK_H

#include <stdint.h>

/* What a planner sends and what the encoders show, each with its sender's counter. */
struct leg_counts {
  int32_t joint_count[2];   /* 65536 a turn, 0 at joint angle 0 */
  int32_t speed_count_s[2]; /* counts per second */
  int32_t desired_count[2], desired_speed_count_s[2];
  int32_t desired_acceleration_count_s2[2];
  uint32_t desired_counter, measured_counter;
  int32_t enable;
};

void leg_start(void);
/* Currents for both drives [mA]; the answer is the status of talus/controller.h. */
uint32_t leg_tick(const struct leg_counts *in, int32_t current_mA[2]);

#endif
