/* parallel_spring.c: a cable, a cover or a bumper beside the joint: linear, stiffening, and its preload at angle 0 */
#include "effects.h"

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  (void)shape;
  torque[0] = now->q;
  torque[1] = now->q * now->q * now->q;
  torque[2] = 1.0;
  friction[0] = friction[1] = friction[2] = 0.0;
}

const tl_effect_kind tl_effect_parallel_spring = {
    .name = "parallel_spring",
    .meaning = "elastic torque in parallel with the joint",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .needs_load_sensor = 0,
    .strengths = 3,
    .shapes = 0,
    .parameter = {{"stiffness_Nm_rad", -50.0, 50.0, 3.0},
                  {"stiffening_Nm_rad3", -500.0, 500.0, 0.0},
                  {"preload_Nm", -20.0, 20.0, 0.0}},
    .law = law,
};
