/* cogging.c: attraction between slots and magnets; its strength is a torque at the motor */
#include "effects.h"

#include "talus/math.h"

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double sine, cosine;

  tl_sincos(shape[0] * now->motor_rad, &sine, &cosine);
  torque[0] = now->ratio * sine;
  torque[1] = now->ratio * cosine;
  friction[0] = friction[1] = 0.0;
}

const tl_effect_kind tl_effect_cogging = {
    .name = "cogging",
    .meaning = "motor torque that is periodic in the motor's angle whatever the current",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .needs_load_sensor = 0,
    .strengths = 2,
    .shapes = 1,
    .parameter = {{"sine_Nm", -1.0, 1.0, 0.003},
                  {"cosine_Nm", -1.0, 1.0, 0.0},
                  {"per_turn", 1.0, 1200.0, 12.0}},
    .law = law,
};
