/* sensor_offset.c: a constant of the output sensor */
#include "../effect_kinds.h"

enum { OFFSET, STRENGTHS };

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  (void)shape;
  (void)now;
  torque[OFFSET] = -1.0; /* a higher reading is a lower torque before the sensor */
  friction[OFFSET] = 0.0;
}

const tl_effect_kind tl_effect_sensor_offset = {
    .name = "sensor_offset",
    .order = 150,
    .meaning = "the zero of the torque sensor at the output",
    .places = TL_EFFECT_AT_SINGLE,
    .acts = TL_EFFECT_MEASURED,
    .needs_load_sensor = 1,
    .strengths = STRENGTHS,
    .shapes = 0,
    .parameter = {[OFFSET] = {"offset_Nm", -1000.0, 1000.0, 0.1, 0, 0.0}},
    .law = law,
};
