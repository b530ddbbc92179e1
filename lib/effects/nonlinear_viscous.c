/* nonlinear_viscous.c: a power of speed beside the linear term: above 1 drag, below 1 a fluid that thins */
#include "effects.h"

#include <math.h>

#include "talus/math.h"

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double size = tl_pow(fabs(now->v), shape[0]);

  torque[0] = now->v < 0.0 ? -size : size;
  friction[0] = 0.0;
}

const tl_effect_kind tl_effect_nonlinear_viscous = {
    .name = "nonlinear_viscous",
    .meaning = "viscous friction that is not linear in speed",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .needs_load_sensor = 0,
    .strengths = 1,
    .shapes = 1,
    .parameter = {{"size_Nm", -50.0, 50.0, 0.1}, {"exponent", 0.2, 3.0, 2.0}},
    .law = law,
};
