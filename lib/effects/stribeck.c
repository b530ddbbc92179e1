/* stribeck.c: friction above Coulomb's near standstill (Stribeck 1902; the exponential form of Bo and Pavelescu 1982) */
#include "../effect_kinds.h"

#include <math.h>

#include "talus/math.h"

enum { EXTRA, STRENGTHS };
enum { SPEED, EXPONENT, SHAPES };

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  torque[EXTRA] = 0.0;
  friction[EXTRA] = tl_exp(-tl_pow(fabs(now->v) / shape[SPEED], shape[EXPONENT]));
}

const tl_effect_kind tl_effect_stribeck = {
    .name = "stribeck",
    .order = 10,
    .meaning = "friction that is higher near standstill and falls with speed to Coulomb's",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .dry = 1,
    .needs_load_sensor = 0,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter = {[EXTRA] = {"extra_Nm", 0.0, 200.0, 0.4, 0, 0.0},
                  [STRENGTHS + SPEED] = {"speed_rad_s", 0.0002, 10.0, 0.1, 0, 0.0},
                  [STRENGTHS + EXPONENT] = {"exponent", 0.5, 2.0, 2.0, 0, 0.0}},
    .law = law,
    .fast = TL_FAST_SPEED,
    .bends_below = STRENGTHS + SPEED,
};
