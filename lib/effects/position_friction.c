/* position_friction.c: friction along the travel, to second order in the angle: misalignment, seals, cables */
#include "effects.h"

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  (void)shape;
  torque[0] = torque[1] = 0.0;
  friction[0] = now->q;
  friction[1] = now->q * now->q;
}

const tl_effect_kind tl_effect_position_friction = {
    .name = "position_friction",
    .meaning = "friction that depends on the joint's angle",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .dry = 1,
    .needs_load_sensor = 0,
    .strengths = 2,
    .shapes = 0,
    .parameter = {{"slope_Nm_rad", -20.0, 20.0, 0.5}, {"bend_Nm_rad2", -50.0, 50.0, 1.0}},
    .law = law,
};
