/* gravity_tilt.c: gravity turned by a small angle, to first order */
#include "../effect_kinds.h"

enum { TILT, STRENGTHS };

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  (void)shape;
  torque[TILT] = now->gravity_tilt_Nm;
  friction[TILT] = 0.0;
}

static tl_status numbers(const tl_effect *e, tl_effect_numbers *to) {
  to->tilt_rad = e->value[TILT];
  return TL_OK;
}

const tl_effect_kind tl_effect_gravity_tilt = {
    .name = "gravity_tilt",
    .order = 120,
    .meaning = "the bench, or the encoders' zero, is tilted against gravity",
    .places = TL_EFFECT_AT_BASE,
    .acts = TL_EFFECT_MECHANICAL,
    .needs_load_sensor = 0,
    .strengths = STRENGTHS,
    .shapes = 0,
    .parameter = {[TILT] = {"tilt_rad", -0.3, 0.3, 0.03, 0, 0.0}},
    .law = law,
    .fast = TL_FAST_NUMBERS,
    .numbers = numbers,
};
