/* current_offset.c: an offset of the current's measurement, as torque at the motor */
#include "../effect_kinds.h"

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  (void)shape;
  torque[0] = now->ratio;
  friction[0] = 0.0;
}

const tl_effect_kind tl_effect_current_offset = {
    .name = "current_offset",
    .order = 110,
    .meaning = "a constant added to the measured current",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MEASURED,
    .needs_load_sensor = 0,
    .strengths = 1,
    .shapes = 0,
    .parameter = {{"torque_Nm", -100.0, 100.0, 0.01, 0, 0.0}},
    .law = law,
};
