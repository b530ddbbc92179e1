/* parallel_spring.c: a cable or a cover beside the joint: a polynomial in the angle, with its preload at angle 0; and
 * a bumper that is met at an angle */
#include "../effect_kinds.h"

enum { STIFFNESS, STIFFENING, PRELOAD, BEND, BUMPER, STRENGTHS };
enum { BUMPER_ANGLE, BUMPER_SIDE, SHAPES };

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double side = shape[BUMPER_SIDE] < 0.0 ? -1.0 : 1.0, depth = side * (now->q - shape[BUMPER_ANGLE]);
  int k;

  torque[STIFFNESS] = now->q;
  torque[STIFFENING] = now->q * now->q * now->q;
  torque[PRELOAD] = 1.0;
  torque[BEND] = now->q * now->q;
  torque[BUMPER] = depth > 0.0 ? side * depth : 0.0;
  for (k = 0; k < STRENGTHS; k++) friction[k] = 0.0;
}

const tl_effect_kind tl_effect_parallel_spring = {
    .name = "parallel_spring",
    .order = 130,
    .meaning = "elastic torque in parallel with the joint",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .needs_load_sensor = 0,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter = {[STIFFNESS] = {"stiffness_Nm_rad", -1e4, 1e4, 3.0, 0, 0.0},
                  [STIFFENING] = {"stiffening_Nm_rad3", -1e6, 1e6, 0.0, 0, 0.0},
                  [PRELOAD] = {"preload_Nm", -1000.0, 1000.0, 0.0, 0, 0.0},
                  [BEND] = {"bend_Nm_rad2", -1e5, 1e5, 0.0, TL_DEFAULT(0.0)},
                  [BUMPER] = {"bumper_Nm_rad", 0.0, 1e5, 0.0, TL_DEFAULT(0.0)},
                  [STRENGTHS + BUMPER_ANGLE] = {"bumper_rad", -1000.0, 1000.0, 0.0, TL_DEFAULT(0.0)},
                  /* below 0: met from above */
                  [STRENGTHS + BUMPER_SIDE] = {"bumper_side", -1.0, 1.0, 1.0, TL_DEFAULT(1.0)}},
    .law = law,
    .fast = TL_FAST_SPRING,
};
