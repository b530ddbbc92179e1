/* controller_prepare.h: from an identified model and its effects to the controller's constant struct.
 *
 *     tl_controller_settings settings;
 *     tl_controller_f64 leg;
 *     tl_curve_knot_f64 knot[TL_CONTROLLER_KNOTS];
 *     int refused;
 *     tl_controller_defaults(&model, &settings);
 *     settings.joint[0].current_limit_A = 12.0;
 *     if (tl_controller_prepare(&leg, &model, effect, effects, &settings, knot, &refused) != TL_OK) return 1;
 *     tl_controller_f32 leg_f32;
 *     tl_curve_knot_f32 knot_f32[TL_CONTROLLER_KNOTS];
 *     tl_controller_to_f32(&leg, knot_f32, &leg_f32);
 *
 * Effects are in it whose kind says a fast form (tl_effect_fast): laws of speed, angle or motor torque, shares of the plain
 * load, offsets, and errors of the linkage. What has a memory, a delay, a temperature or ripples of the motor's turn is
 * refused by its place in the list.
 */
#ifndef TALUS_CONTROLLER_PREPARE_H
#define TALUS_CONTROLLER_PREPARE_H

#include "talus/controller.h"
#include "talus/experimental/effect.h"
#include "talus/plant.h"
#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_CONTROLLER_CURVE_KNOTS 65 /* of the curves of effects */
#define TL_CONTROLLER_KNOTS (2 * (2 * TL_CURVE_MAX_KNOTS + 5 * TL_CONTROLLER_CURVE_KNOTS))
#define TL_CONTROLLER_DECAY_S 0.020 /* from the last good frame to zero torque, at most */

/* What one joint may do. All > 0 but low_rad and friction_share. */
typedef struct tl_controller_joint_settings {
  double current_limit_A;           /* peak of the drive */
  double torque_limit_Nm;           /* of the motor; the current limit counts too */
  double rate_Nm_s;                 /* of the motor's torque */
  double power_limit_W;             /* of |motor torque x motor speed| */
  double low_rad, high_rad;         /* the joint's stops; with a linkage or series within +-30 degrees */
  double fade_rad;                  /* before a stop, torque towards it fades over this way, at most 1 */
  double speed_limit_rad_s;         /* frames beyond these are impossible, at most 32 */
  double acceleration_limit_rad_s2; /* at most 1024 */
  double slack_rad;                 /* a frame's angle may be off by this: noise and counts */
  double friction_fade_rad_s; /* below this desired speed, friction is compensated in proportion to it */
  double friction_share;      /* of the model's friction that is compensated, [0, 1] */
  double frozen_rad_s;        /* above this speed a measured angle that stands still is frozen */
} tl_controller_joint_settings;

typedef struct tl_controller_settings {
  double tick_s;
  int stale_ticks;   /* without a good frame, before torque decays; >= 0 */
  int decay_ticks;   /* of the decay, >= 2; (stale_ticks + decay_ticks) tick_s <= TL_CONTROLLER_DECAY_S */
  int recover_ticks; /* good frames before torque comes back, 1..1000 */
  tl_controller_joint_settings joint[TL_CONTROLLER_JOINTS];
} tl_controller_settings;

/* 1 kHz, 20 A, 200 W, stops at +-115 degrees (knee) and +-30 degrees (ankle), all of the friction, and 1.25
 * times the least rate that these allow. The machine's own limits are its maker's: look at every one. */
void tl_controller_defaults(const tl_model *model, tl_controller_settings *settings);
/* The smallest rate [N m/s] at which the torque limit decays in time and the power limit can always be kept:
 * (torque^2 / 2 power) |ratio| acceleration (stale_ticks + 1). */
double tl_controller_least_rate(const tl_controller_settings *settings, const tl_model *model, int joint);

/* Fills *c; `knot` has room for TL_CONTROLLER_KNOTS and must outlive it.
 * TL_ERR_UNSUPPORTED: an effect without a fast form, then *refused is its index; or with *refused = -1 a plant that is
 * not the leg, the form of the paper, a drive without ratio in closed form. TL_ERR_RANGE: a setting or a model's number
 * (with *refused >= 0: that effect's). Nullable: effect, where effects is 0. */
TL_CHECK tl_status tl_controller_prepare(tl_controller_f64 *c, const tl_model *model, const tl_effect *effect,
                                         int effects, const tl_controller_settings *settings,
                                         tl_curve_knot_f64 *knot, int *refused);

/* The same controller in float and in fixed point, with knots of its own. TL_ERR_RANGE: fixed point's formats cannot hold
 * a number, or a sum within the limits. */
void tl_controller_to_f32(const tl_controller_f64 *c, tl_curve_knot_f32 *knot, tl_controller_f32 *out);
TL_CHECK tl_status tl_controller_to_q31(const tl_controller_f64 *c, tl_curve_knot_q31 *knot,
                                        tl_controller_q31 *out);

/* A number of tl_controller or tl_controller_joint, or a curve of the latter: where it stands in each kind of struct,
 * how many there are in a row, and its fraction bits in fixed point (of
 * a curve: its argument's). */
typedef struct tl_controller_field {
  const char *name;
  size_t f64, f32, q31; /* offsets */
  int count, q;
} tl_controller_field;
const tl_controller_field *tl_controller_fields(int *n);
const tl_controller_field *tl_controller_joint_fields(int *n);
const tl_controller_field *tl_controller_curves(int *n);

/* What fixed point and tables may add to the motor torques of tl_controller_torque_q31 [N m]: |fixed - true| is at most
 * this for every desired frame within the limits. `true` is the model in closed form with effects as their curves have
 * them; what interpolation does to those curves is in `curves_Nm`, looked at in 16 points a step and not proven. */
typedef struct tl_controller_bound {
  double fixed_Nm[TL_CONTROLLER_JOINTS];
  double curves_Nm[TL_CONTROLLER_JOINTS];
} tl_controller_bound;
/* Arguments as they were given to tl_controller_prepare. */
TL_CHECK tl_status tl_controller_error_bound(const tl_controller_f64 *c, const tl_model *model,
                                             const tl_effect *effect, int effects,
                                             const tl_controller_settings *settings,
                                             tl_controller_bound *bound);

/* Number of knots that the curves of c have together, in the order in which the copies lay them out. */
int tl_controller_knots(const tl_controller_f64 *c);

#ifdef __cplusplus
}
#endif
#endif
