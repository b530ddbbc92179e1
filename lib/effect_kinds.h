/* effect_kinds.h: what the files of lib/effects/ share, one file a kind; internal to lib/.
 *
 * A kind's file is its only place in C: lib/effects/NAME.c defines `const tl_effect_kind tl_effect_NAME`, and the
 * Makefile makes the table of lib/effect.c from the folder. It names its strengths and its shapes in two enums, each from
 * 0: laws and columns have `shape[SPEED]`, and fill `torque[EXTRA]`; among all of an effect's values, and in the table of
 * its parameters, a shape stands at STRENGTHS + SPEED.
 */
#ifndef TALUS_EFFECT_KINDS_H
#define TALUS_EFFECT_KINDS_H

#include "talus/experimental/effect.h"

/* end of a parameter that a model file may leave out: flags, and the value it then has */
#define TL_DEFAULT(value) TL_PARAMETER_OPTIONAL, value
#define TL_FIT_ONLY(value) TL_PARAMETER_OPTIONAL | TL_PARAMETER_FIT_ONLY, value
#define TL_NEEDS_TEMPERATURE                                                                                 \
  TL_PARAMETER_OPTIONAL | TL_PARAMETER_FIT_ONLY | TL_PARAMETER_NEEDS_TEMPERATURE, 0.0

/* Share of the joint's own inertia that turns with its motor, where neither the model tells them apart nor the
 * effect says: of the shank's at the knee (which holds the knee's reflected rotor), of all of a single joint's. */
#define TL_EFFECT_MOTOR_SHARE 0.4

#define TL_EFFECT_AT_JOINTS (TL_EFFECT_AT_KNEE | TL_EFFECT_AT_ANKLE | TL_EFFECT_AT_SINGLE)

/* The part of a ripple, so many a turn of the motor, that the current shows: half of it at fades_Hz (0: all), less of
 * a faster one, which position control and smoothed accelerations no longer follow. */
double tl_effect_ripple_shown(const tl_effect_instant *now, double per_turn, double fades_Hz);

/* Beside another effect of the same joint the larger of two values counts. */
static inline void tl_effect_larger(double *to, double value) {
  if (value > *to) *to = value;
}

/* Places of the shapes that say what of a joint's torque its gear carries; a law's own follow. */
enum { TL_LOAD_ROTOR, TL_LOAD_FRICTION, TL_LOAD_OFFSET, TL_LOAD_SHAPES };
/* The load that friction grows with: inertia and gravity, with so much of the rotor's, of the plain friction and of the
 * constant torque. */
double tl_effect_load(const tl_effect_instant *now, const double shape[TL_LOAD_SHAPES]);
/* is it that of inertia and gravity, and nothing else said of it? */
int tl_effect_load_is_plain(const tl_effect *e);

#endif
