/* load_friction.c: friction in proportion to the load (Dohring, Lee and Newman 1993; Bittencourt and Gunnarsson 2012) */
#include "effects.h"

#include <math.h>

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  (void)shape;
  torque[0] = 0.0;
  friction[0] = fabs(now->load_Nm);
}

const tl_effect_kind tl_effect_load_friction = {
    .name = "load_friction",
    .meaning = "friction that grows with the torque the gear carries",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .dry = 1,
    .needs_load_sensor = 0,
    .strengths = 1,
    .shapes = 0,
    .parameter = {{"coefficient", 0.0, 0.6, 0.1}},
    .law = law,
};
