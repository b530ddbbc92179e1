/* effect_kinds.h: the kinds of effects, one file each in this folder; internal to lib/.
 *
 * To add one: write its file, declare it here, and put it into the table of lib/effect.c.
 */
#ifndef TALUS_EFFECT_KINDS_H
#define TALUS_EFFECT_KINDS_H

#include "talus/experimental/effect.h"

/* end of a parameter that a model file may leave out: flags, and the value it then has */
#define TL_DEFAULT(value) TL_PARAMETER_OPTIONAL, value
#define TL_FIT_ONLY(value) TL_PARAMETER_OPTIONAL | TL_PARAMETER_FIT_ONLY, value
#define TL_NEEDS_TEMPERATURE                                                                                 \
  TL_PARAMETER_OPTIONAL | TL_PARAMETER_FIT_ONLY | TL_PARAMETER_NEEDS_TEMPERATURE, 0.0

#define TL_EFFECT_AT_JOINTS (TL_EFFECT_AT_KNEE | TL_EFFECT_AT_ANKLE | TL_EFFECT_AT_SINGLE)

extern const tl_effect_kind tl_effect_stribeck, tl_effect_load_friction, tl_effect_asymmetric_friction,
    tl_effect_nonlinear_viscous, tl_effect_position_friction, tl_effect_friction_drift,
    tl_effect_directional_efficiency, tl_effect_kinematic_error, tl_effect_cogging,
    tl_effect_torque_saturation, tl_effect_current_offset, tl_effect_gravity_tilt, tl_effect_parallel_spring,
    tl_effect_torque_constant, tl_effect_sensor_offset, tl_effect_delay, tl_effect_encoder_eccentricity,
    tl_effect_linkage_error, tl_effect_presliding, tl_effect_elasticity, tl_effect_backlash,
    tl_effect_base_compliance;

/* The part of a ripple, so many a turn of the motor, that the current shows: half of it at fades_Hz (0: all), less of
 * a faster one, which position control and smoothed accelerations no longer follow. */
double tl_effect_ripple_shown(const tl_effect_instant *now, double per_turn, double fades_Hz);

/* The load that friction grows with: with so much of the rotor's and of the plain friction's share. */
double tl_effect_load(const tl_effect_instant *now, double rotor_share, double friction_share);

#endif
