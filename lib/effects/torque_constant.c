/* torque_constant.c: the drive delivers (1 + excess) of what current times constant says; needs a sensor at the output */
#include "effects.h"

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  (void)shape;
  torque[0] = -now->effort_Nm; /* what the drive gives more need not be asked for */
  friction[0] = 0.0;
}

const tl_effect_kind tl_effect_torque_constant = {
    .name = "torque_constant",
    .meaning = "the torque constant is wrong by a factor",
    .places = TL_EFFECT_AT_SINGLE,
    .acts = TL_EFFECT_MEASURED,
    .needs_load_sensor = 1,
    .strengths = 1,
    .shapes = 0,
    .parameter = {{"excess", -0.9, 2.0, 0.1, 0, 0.0}},
    .law = law,
};
