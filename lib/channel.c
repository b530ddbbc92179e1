/* channel.c: names of the channels. */
#include "talus/channel.h"

#include <stddef.h>

static const char *const channel_name[TL_CHANNEL_COUNT] = {
    "time_s",           "valid",
    "knee_motor_rad",   "ankle_motor_rad",
    "ankle_joint_rad",  "knee_current_A",
    "ankle_current_A",  "shank_rad",
    "foot_rad",         "knee_temp_C",
    "ankle_temp_C",     "bus_V",
    "joint_rad",        "joint_velocity_rad_s",
    "joint_current_A",  "joint_torque_Nm",
    "joint_load_Nm",    "joint_temp_C",
    "slider_m",         "slider_force_N",
    "slider_command_m",
};

const char *tl_channel_name(tl_channel channel) {
  const int index = (int)channel;
  return index >= 0 && index < TL_CHANNEL_COUNT ? channel_name[index] : NULL;
}
