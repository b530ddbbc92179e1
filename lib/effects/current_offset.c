/* current_offset.c: an offset of the current's measurement, as torque at the motor */
#include "../effect_kinds.h"

enum { TORQUE, STRENGTHS };

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  (void)shape;
  torque[TORQUE] = now->ratio;
  friction[TORQUE] = 0.0;
}

static tl_status numbers(const tl_effect *e, tl_effect_numbers *to) {
  to->offset_Nm = e->value[TORQUE];
  return TL_OK;
}

const tl_effect_kind tl_effect_current_offset = {
    .name = "current_offset",
    .order = 110,
    .meaning = "a constant added to the measured current",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MEASURED,
    .needs_load_sensor = 0,
    .strengths = STRENGTHS,
    .shapes = 0,
    .parameter = {[TORQUE] = {"torque_Nm", -100.0, 100.0, 0.01, 0, 0.0}},
    .law = law,
    .fast = TL_FAST_NUMBERS,
    .numbers = numbers,
};
