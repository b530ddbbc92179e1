/* cogging.c: attraction between slots and magnets; its strength is a torque at the motor */
#include "../effect_kinds.h"

#include "talus/math.h"

enum { SINE, COSINE, OVERTONE_SINE, OVERTONE_COSINE, STRENGTHS };
enum { PER_TURN, FADES, SHAPES };

double tl_effect_ripple_shown(const tl_effect_instant *now, double per_turn, double fades_Hz) {
  double part = fades_Hz > 0.0 ? per_turn * now->v * now->ratio / (2.0 * TL_PI * fades_Hz) : 0.0;

  return 1.0 / (1.0 + part * part * part * part);
}

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double sine, cosine, shown;
  int k;

  for (k = 0; k < 2; k++) { /* the order, and twice that */
    tl_sincos((k + 1) * shape[PER_TURN] * now->motor_rad, &sine, &cosine);
    shown = now->ratio * tl_effect_ripple_shown(now, (k + 1) * shape[PER_TURN], shape[FADES]);
    torque[k == 0 ? SINE : OVERTONE_SINE] = shown * sine;
    torque[k == 0 ? COSINE : OVERTONE_COSINE] = shown * cosine;
  }
  for (k = 0; k < STRENGTHS; k++) friction[k] = 0.0;
}

const tl_effect_kind tl_effect_cogging = {
    .name = "cogging",
    .order = 90,
    .meaning = "motor torque that is periodic in the motor's angle whatever the current",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .needs_load_sensor = 0,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter = {[SINE] = {"sine_Nm", -10.0, 10.0, 0.003, 0, 0.0},
                  [COSINE] = {"cosine_Nm", -10.0, 10.0, 0.0, 0, 0.0},
                  /* at twice the order */
                  [OVERTONE_SINE] = {"overtone_sine_Nm", -10.0, 10.0, 0.0, TL_DEFAULT(0.0)},
                  [OVERTONE_COSINE] = {"overtone_cosine_Nm", -10.0, 10.0, 0.0, TL_DEFAULT(0.0)},
                  [STRENGTHS + PER_TURN] = {"per_turn", 0.01, 1200.0, 12.0, 0, 0.0},
                  [STRENGTHS + FADES] = {"fades_Hz", 0.0, 1000.0, 0.0, TL_DEFAULT(0.0)}},
    .law = law,
};
