/* load_friction.c: friction in proportion to the load (Dohring, Lee and Newman 1993; Bittencourt and Gunnarsson 2012).
 * What the gear carries is read in several ways: with or without its rotor's inertia, friction, or a constant torque; and where
 * it is the motor's torque T, this friction carries itself: T = X + c |T| slip is X + (c |X| slip + c^2 X) / (1 - c^2). */
#include "../effect_kinds.h"

#include <math.h>

#include "talus/math.h"

enum { COEFFICIENT, STRENGTHS };
enum { EXPONENT = TL_LOAD_SHAPES, SCALE, OWN_COEFFICIENT, SHAPES };

double tl_effect_load(const tl_effect_instant *now, const double shape[TL_LOAD_SHAPES]) {
  return now->load_Nm - (1.0 - shape[TL_LOAD_ROTOR]) * now->rotor_Nm +
         shape[TL_LOAD_FRICTION] * now->friction_Nm + shape[TL_LOAD_OFFSET] * now->offset_Nm;
}

int tl_effect_load_is_plain(const tl_effect *e) {
  int i;

  for (i = e->kind->strengths; i < e->kind->strengths + e->kind->shapes; i++)
    if (tl_effect_says(e, i)) return 0;
  return 1;
}

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double carried = tl_effect_load(now, shape), load = fabs(carried);
  double own = shape[OWN_COEFFICIENT], level = load;

  if (shape[EXPONENT] != 1.0) level = load * tl_pow(load / shape[SCALE], shape[EXPONENT] - 1.0);
  torque[COEFFICIENT] = own * carried / (1.0 - own * own);
  friction[COEFFICIENT] = level / (1.0 - own * own);
}

static tl_status numbers(const tl_effect *e, tl_effect_numbers *to) {
  if (!tl_effect_load_is_plain(e)) return TL_ERR_UNSUPPORTED;
  to->driving = to->back_driving = e->value[COEFFICIENT];
  return TL_OK;
}

const tl_effect_kind tl_effect_load_friction = {
    .name = "load_friction",
    .order = 20,
    .meaning = "friction that grows with the torque the gear carries",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .dry = 1,
    .needs_load_sensor = 0,
    .rotor_share = STRENGTHS + TL_LOAD_ROTOR,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter = {[COEFFICIENT] = {"coefficient", 0.0, 0.9, 0.1, 0, 0.0},
                  [STRENGTHS + TL_LOAD_ROTOR] = {"rotor_share", 0.0, 1.0, 1.0, TL_DEFAULT(1.0)},
                  [STRENGTHS + TL_LOAD_FRICTION] = {"friction_share", 0.0, 1.0, 0.0, TL_DEFAULT(0.0)},
                  [STRENGTHS + TL_LOAD_OFFSET] = {"offset_share", 0.0, 1.0, 0.0, TL_DEFAULT(0.0)},
                  /* above 1: the coefficient holds at scale_Nm */
                  [STRENGTHS + EXPONENT] = {"exponent", 1.0, 3.0, 1.0, TL_DEFAULT(1.0)},
                  [STRENGTHS + SCALE] = {"scale_Nm", 1e-6, 10000.0, 1.0, TL_DEFAULT(1.0)},
                  /* where it carries itself */
                  [STRENGTHS + OWN_COEFFICIENT] = {"own_coefficient", 0.0, 0.6, 0.0, TL_DEFAULT(0.0)}},
    .law = law,
    .fast = TL_FAST_NUMBERS,
    .numbers = numbers,
};
