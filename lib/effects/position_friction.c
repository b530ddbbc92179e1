/* position_friction.c: friction along the travel: a polynomial in the angle, and a wave: misalignment, seals, cables */
#include "../effect_kinds.h"

#include "talus/math.h"

enum { SLOPE, BEND, CUBIC, QUARTIC, SINE, COSINE, STRENGTHS };
enum { MIDDLE, WAVE, RANGE, SHAPES };

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double x = now->q - shape[MIDDLE], end = shape[RANGE], power;
  int k;

  for (k = 0; k < STRENGTHS; k++) torque[k] = 0.0;
  tl_sincos(shape[WAVE] * x, &friction[SINE], &friction[COSINE]);
  if (end > 0.0) x = x > end ? end : x < -end ? -end : x; /* what was fitted to a range says nothing beyond */
  power = x;
  for (k = SLOPE; k <= QUARTIC; k++) {
    friction[k] = power;
    power *= x;
  }
}

const tl_effect_kind tl_effect_position_friction = {
    .name = "position_friction",
    .order = 50,
    .meaning = "friction that depends on the joint's angle",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .dry = 1,
    .needs_load_sensor = 0,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter = {[SLOPE] = {"slope_Nm_rad", -1e4, 1e4, 0.5, 0, 0.0},
                  [BEND] = {"bend_Nm_rad2", -1e6, 1e6, 1.0, 0, 0.0},
                  [CUBIC] = {"cubic_Nm_rad3", -1e8, 1e8, 0.0, TL_DEFAULT(0.0)},
                  [QUARTIC] = {"quartic_Nm_rad4", -1e10, 1e10, 0.0, TL_DEFAULT(0.0)},
                  [SINE] = {"sine_Nm", -100.0, 100.0, 0.0, TL_DEFAULT(0.0)},
                  [COSINE] = {"cosine_Nm", -100.0, 100.0, 0.0, TL_DEFAULT(0.0)},
                  /* the angle counts from here */
                  [STRENGTHS + MIDDLE] = {"middle_rad", -1000.0, 1000.0, 0.0, TL_DEFAULT(0.0)},
                  [STRENGTHS + WAVE] = {"wave_1_rad", 0.0, 10000.0, 0.0, TL_DEFAULT(0.0)},
                  /* of the polynomial, to each side; 0: any */
                  [STRENGTHS + RANGE] = {"range_rad", 0.0, 1000.0, 0.0, TL_DEFAULT(0.0)}},
    .law = law,
    .fast = TL_FAST_POSITION,
};
