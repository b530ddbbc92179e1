/* twin_states.c: see twin_states.h. */
#include "twin_states.h"

#include <math.h>

void twin_states_settings(const struct model_bus *bus, tl_twin_settings *s) {
  const double turn = 2.0 * acos(-1.0);

  s->sample_hz = s->control_hz;
  s->jitter_s = 0.0;
  for (int j = 0; j < TL_MAX_JOINTS; j++) s->drive_step_rad[j] = turn / bus->joint[j].motor_counts_per_turn;
  s->ankle_step_rad = turn / bus->joint[1].joint_counts_per_turn;
}

void twin_states_pack(const tl_twin *b, const struct model_bus *bus, uint16_t counter,
                      const double row[TL_CHANNEL_COUNT], const double zero_count[TL_MAX_JOINTS],
                      struct leg_bus_frame frame[TL_MAX_JOINTS]) {
  static const tl_channel motor[] = {TL_CHANNEL_KNEE_MOTOR, TL_CHANNEL_ANKLE_MOTOR};
  static const tl_channel current[] = {TL_CHANNEL_KNEE_CURRENT, TL_CHANNEL_ANKLE_CURRENT};
  tl_motion joints;

  tl_simulation_joints(b->model, &b->simulation, &joints);
  joints.q[1] = row[TL_CHANNEL_ANKLE_JOINT]; /* with its encoder's own errors */
  for (int j = 0; j < TL_MAX_JOINTS; j++) {
    const struct model_bus_joint *of = &bus->joint[j];
    const struct leg_bus_state state = {.counter = counter,
                                        .motor_count = leg_bus_motor_count(of, row[motor[j]], zero_count[j]),
                                        .joint_count = leg_bus_joint_count(of, joints.q[j]),
                                        .current_A = leg_bus_current_A(of, row[current[j]])};
    leg_bus_pack_state(&frame[j], j, &state);
  }
}
