/* nonlinear_viscous.c: a power of speed beside the linear term: above 1 drag, below 1 a fluid that thins; or a fluid
 * whose friction saturates */
#include "../effect_kinds.h"

#include <math.h>

#include "talus/math.h"

enum { SIZE, STRENGTHS };
enum { EXPONENT, SATURATION, SHAPES };

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double speed = fabs(now->v);
  double size = shape[SATURATION] > 0.0 ? tl_tanh(speed / shape[SATURATION]) : tl_pow(speed, shape[EXPONENT]);

  torque[SIZE] = now->v < 0.0 ? -size : size;
  friction[SIZE] = 0.0;
}

const tl_effect_kind tl_effect_nonlinear_viscous = {
    .name = "nonlinear_viscous",
    .order = 40,
    .meaning = "viscous friction that is not linear in speed",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .needs_load_sensor = 0,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter = {[SIZE] = {"size_Nm", -1000.0, 1000.0, 0.1, 0, 0.0},
                  [STRENGTHS + EXPONENT] = {"exponent", 0.2, 3.0, 2.0, 0, 0.0},
                  /* above 0 in the exponent's place */
                  [STRENGTHS + SATURATION] = {"saturation_rad_s", 0.0, 100.0, 0.0, TL_DEFAULT(0.0)}},
    .law = law,
    .fast = TL_FAST_SPEED,
};
