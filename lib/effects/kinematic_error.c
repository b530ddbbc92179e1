/* kinematic_error.c: ripple once, twice or four times a turn of the wave generator, at the joint (Tuttle and Seering 1996) */
#include "effects.h"

#include "talus/math.h"

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  tl_sincos(shape[0] * now->motor_rad, &torque[0], &torque[1]);
  friction[0] = friction[1] = 0.0;
}

const tl_effect_kind tl_effect_kinematic_error = {
    .name = "kinematic_error",
    .meaning = "torque ripple of a harmonic drive's wave generator",
    .places = TL_EFFECT_AT_KNEE | TL_EFFECT_AT_SINGLE,
    .acts = TL_EFFECT_MECHANICAL,
    .needs_load_sensor = 0,
    .strengths = 2,
    .shapes = 1,
    .parameter = {{"sine_Nm", -5.0, 5.0, 0.2}, {"cosine_Nm", -5.0, 5.0, 0.0}, {"per_turn", 1.0, 4.0, 2.0}},
    .law = law,
};
