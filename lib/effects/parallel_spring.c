/* parallel_spring.c: a cable or a cover beside the joint: a polynomial in the angle, with its preload at angle 0; and
 * a bumper that is met at an angle */
#include "../effect_kinds.h"

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double side = shape[1] < 0.0 ? -1.0 : 1.0, depth = side * (now->q - shape[0]);
  int k;

  torque[0] = now->q;
  torque[1] = now->q * now->q * now->q;
  torque[2] = 1.0;
  torque[3] = now->q * now->q;
  torque[4] = depth > 0.0 ? side * depth : 0.0;
  for (k = 0; k < 5; k++) friction[k] = 0.0;
}

const tl_effect_kind tl_effect_parallel_spring = {
    .name = "parallel_spring",
    .order = 130,
    .meaning = "elastic torque in parallel with the joint",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .needs_load_sensor = 0,
    .strengths = 5,
    .shapes = 2,
    .parameter = {{"stiffness_Nm_rad", -1e4, 1e4, 3.0, 0, 0.0},
                  {"stiffening_Nm_rad3", -1e6, 1e6, 0.0, 0, 0.0},
                  {"preload_Nm", -1000.0, 1000.0, 0.0, 0, 0.0},
                  {"bend_Nm_rad2", -1e5, 1e5, 0.0, TL_DEFAULT(0.0)},
                  {"bumper_Nm_rad", 0.0, 1e5, 0.0, TL_DEFAULT(0.0)},
                  {"bumper_rad", -1000.0, 1000.0, 0.0, TL_DEFAULT(0.0)},
                  {"bumper_side", -1.0, 1.0, 1.0, TL_DEFAULT(1.0)}}, /* below 0: met from above */
    .law = law,
};
