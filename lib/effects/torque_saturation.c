/* torque_saturation.c: the motor's iron saturates: what the current shows is more than the torque */
#include "effects.h"

#include <math.h>

#include "talus/math.h"

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double size = fabs(now->motor_Nm);

  /* the current must be higher than torque over constant: by torque * droop * |torque|^exponent */
  torque[0] = now->ratio * now->motor_Nm * tl_pow(size, shape[0]);
  friction[0] = 0.0;
}

const tl_effect_kind tl_effect_torque_saturation = {
    .name = "torque_saturation",
    .meaning = "a torque constant that droops with the current",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MEASURED,
    .needs_load_sensor = 0,
    .strengths = 1,
    .shapes = 1,
    .parameter = {{"droop_1_Nm", -5.0, 50.0, 0.5}, {"exponent", 1.0, 3.0, 1.0}},
    .law = law,
};
