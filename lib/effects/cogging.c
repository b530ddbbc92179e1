/* cogging.c: attraction between slots and magnets; its strength is a torque at the motor */
#include "../effect_kinds.h"

#include "talus/math.h"

double tl_effect_ripple_shown(const tl_effect_instant *now, double per_turn, double fades_Hz) {
  double part = fades_Hz > 0.0 ? per_turn * now->v * now->ratio / (2.0 * TL_PI * fades_Hz) : 0.0;

  return 1.0 / (1.0 + part * part * part * part);
}

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double sine, cosine, shown;
  int k;

  for (k = 0; k < 2; k++) {
    tl_sincos((k + 1) * shape[0] * now->motor_rad, &sine, &cosine);
    shown = now->ratio * tl_effect_ripple_shown(now, (k + 1) * shape[0], shape[1]);
    torque[2 * k] = shown * sine;
    torque[2 * k + 1] = shown * cosine;
    friction[2 * k] = friction[2 * k + 1] = 0.0;
  }
}

const tl_effect_kind tl_effect_cogging = {
    .name = "cogging",
    .order = 90,
    .meaning = "motor torque that is periodic in the motor's angle whatever the current",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .needs_load_sensor = 0,
    .strengths = 4,
    .shapes = 2,
    .parameter = {{"sine_Nm", -10.0, 10.0, 0.003, 0, 0.0},
                  {"cosine_Nm", -10.0, 10.0, 0.0, 0, 0.0},
                  {"overtone_sine_Nm", -10.0, 10.0, 0.0, TL_DEFAULT(0.0)}, /* at twice the order */
                  {"overtone_cosine_Nm", -10.0, 10.0, 0.0, TL_DEFAULT(0.0)},
                  {"per_turn", 0.01, 1200.0, 12.0, 0, 0.0},
                  {"fades_Hz", 0.0, 1000.0, 0.0, TL_DEFAULT(0.0)}},
    .law = law,
};
