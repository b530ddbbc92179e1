/* torque_saturation.c: the motor's iron saturates: what the current shows is more than the torque */
#include "../effect_kinds.h"

#include <math.h>

#include "talus/math.h"

enum { DROOP, STRENGTHS };
enum { EXPONENT, BEGIN, SHAPES };

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double beyond = fabs(now->motor_Nm) - shape[BEGIN];

  /* the current must be higher than torque over constant: by droop times a power of the torque beyond `begin` */
  torque[DROOP] = beyond > 0.0 ? now->ratio * tl_pow(beyond, 1.0 + shape[EXPONENT]) : 0.0;
  if (now->motor_Nm < 0.0) torque[DROOP] = -torque[DROOP];
  friction[DROOP] = 0.0;
}

const tl_effect_kind tl_effect_torque_saturation = {
    .name = "torque_saturation",
    .order = 100,
    .meaning = "a torque constant that droops with the current",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MEASURED,
    .needs_load_sensor = 0,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter = {[DROOP] = {"droop_1_Nm", -1e30, 1e30, 0.5, 0, 0.0}, /* 1 / Nm^exponent */
                  [STRENGTHS + EXPONENT] = {"exponent", 0.0, 8.0, 1.0, 0, 0.0},
                  [STRENGTHS + BEGIN] = {"begin_Nm", 0.0, 1e4, 0.0, TL_DEFAULT(0.0)}},
    .law = law,
    .fast = TL_FAST_DROOP,
};
