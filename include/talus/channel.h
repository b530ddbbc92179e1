/* channel.h: the columns of a recording by meaning.
 *
 * A recording holds the channels that its plant knows (tl_channel_set_of), in any order; each has
 * one name, which is also its column's name and says its unit.
 *
 *     uint32_t recorded = TL_CHANNEL_BIT(TL_CHANNEL_TIME) | TL_CHANNEL_BIT(TL_CHANNEL_SLIDER);
 *     if (recorded & TL_CHANNEL_BIT(TL_CHANNEL_SLIDER))
 *       puts(tl_channel_name(TL_CHANNEL_SLIDER)); // prints slider_m
 */
#ifndef TALUS_CHANNEL_H
#define TALUS_CHANNEL_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum tl_channel {
  TL_CHANNEL_TIME = 0, /* time_s: rises strictly */
  TL_CHANNEL_VALID,    /* valid: 0 or 1; 0 is kept in time but not fitted or scored */
  /* leg */
  TL_CHANNEL_KNEE_MOTOR,    /* knee_motor_rad: the rotor's angle */
  TL_CHANNEL_ANKLE_MOTOR,   /* ankle_motor_rad: the rotor's angle */
  TL_CHANNEL_ANKLE_JOINT,   /* ankle_joint_rad: absolute encoder at the joint */
  TL_CHANNEL_KNEE_CURRENT,  /* knee_current_A */
  TL_CHANNEL_ANKLE_CURRENT, /* ankle_current_A */
  TL_CHANNEL_SHANK,         /* shank_rad: absolute angle from the camera */
  TL_CHANNEL_FOOT,          /* foot_rad: absolute angle from the camera */
  TL_CHANNEL_KNEE_TEMP,     /* knee_temp_C */
  TL_CHANNEL_ANKLE_TEMP,    /* ankle_temp_C */
  /* leg and pendulum */
  TL_CHANNEL_BUS, /* bus_V */
  /* pendulum */
  TL_CHANNEL_JOINT,          /* joint_rad */
  TL_CHANNEL_JOINT_VELOCITY, /* joint_velocity_rad_s */
  TL_CHANNEL_JOINT_CURRENT,  /* joint_current_A */
  TL_CHANNEL_JOINT_TORQUE,   /* joint_torque_Nm */
  TL_CHANNEL_JOINT_LOAD,     /* joint_load_Nm: what the joint delivers to its load */
  TL_CHANNEL_JOINT_TEMP,     /* joint_temp_C */
  /* slider */
  TL_CHANNEL_SLIDER,         /* slider_m */
  TL_CHANNEL_SLIDER_FORCE,   /* slider_force_N */
  TL_CHANNEL_SLIDER_COMMAND, /* slider_command_m */
  TL_CHANNEL_COUNT
} tl_channel;

#define TL_NO_CHANNEL TL_CHANNEL_COUNT

/* A channel's place in a set of channels. */
#define TL_CHANNEL_BIT(channel) ((uint32_t)1 << (channel))

/* The column's name, e.g. "knee_current_A"; NULL for a number that is no channel. */
const char *tl_channel_name(tl_channel channel);

#ifdef __cplusplus
}
#endif
#endif
