/* channel.c: names of the channels, and which plant has which. */
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

#define BIT(name) TL_CHANNEL_BIT(TL_CHANNEL_##name)

static const uint32_t leg_required = BIT(TIME) | BIT(KNEE_MOTOR) | BIT(ANKLE_MOTOR) | BIT(ANKLE_JOINT) |
                                     BIT(KNEE_CURRENT) | BIT(ANKLE_CURRENT);
static const uint32_t leg_optional =
    BIT(VALID) | BIT(SHANK) | BIT(FOOT) | BIT(KNEE_TEMP) | BIT(ANKLE_TEMP) | BIT(BUS);

static const uint32_t pendulum_motion = BIT(JOINT) | BIT(JOINT_VELOCITY);
static const uint32_t pendulum_drive = BIT(JOINT_CURRENT) | BIT(JOINT_TORQUE);
static const uint32_t pendulum_optional = BIT(VALID) | BIT(JOINT_LOAD) | BIT(JOINT_TEMP) | BIT(BUS);

static const uint32_t slider_required = BIT(TIME) | BIT(SLIDER) | BIT(SLIDER_FORCE);
static const uint32_t slider_optional = BIT(VALID) | BIT(SLIDER_COMMAND);

const char *tl_channel_name(tl_channel channel) {
  const int index = (int)channel;
  return index >= 0 && index < TL_CHANNEL_COUNT ? channel_name[index] : NULL;
}

static void fill(tl_channel_set *set, uint32_t required, uint32_t optional, uint32_t motion, uint32_t drive) {
  set->known = required | optional | motion | drive;
  set->required = required;
  set->any_of[0] = motion;
  set->any_of[1] = drive;
}

tl_status tl_channel_set_of(tl_plant plant, tl_channel_set *set) {
  if (!set) return TL_ERR_ARGUMENT;
  switch (plant) {
  case TL_PLANT_LEG: fill(set, leg_required, leg_optional, 0, 0); return TL_OK;
  case TL_PLANT_PENDULUM:
    fill(set, BIT(TIME), pendulum_optional, pendulum_motion, pendulum_drive);
    return TL_OK;
  case TL_PLANT_SLIDER: fill(set, slider_required, slider_optional, 0, 0); return TL_OK;
  }
  return TL_ERR_ARGUMENT;
}
