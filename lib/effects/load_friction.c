/* load_friction.c: friction in proportion to the load (Dohring, Lee and Newman 1993; Bittencourt and Gunnarsson 2012).
 * What the gear carries is read in several ways: with or without its rotor's inertia, with or without friction; and where it
 * is the motor's torque T, this friction carries itself: T = X + c |T| slip is X + (c |X| slip + c^2 X) / (1 - c^2). */
#include "../effect_kinds.h"

#include <math.h>

#include "talus/math.h"

double tl_effect_load(const tl_effect_instant *now, double rotor_share, double friction_share) {
  return now->load_Nm - (1.0 - rotor_share) * now->rotor_Nm + friction_share * now->friction_Nm;
}

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double carried = tl_effect_load(now, shape[0], shape[1]), load = fabs(carried), own = shape[4];

  torque[0] = own * carried / (1.0 - own * own);
  friction[0] = shape[2] == 1.0 ? load : load * tl_pow(load / shape[3], shape[2] - 1.0);
  friction[0] /= 1.0 - own * own;
}

const tl_effect_kind tl_effect_load_friction = {
    .name = "load_friction",
    .order = 20,
    .meaning = "friction that grows with the torque the gear carries",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .dry = 1,
    .needs_load_sensor = 0,
    .rotor_share = 1,
    .strengths = 1,
    .shapes = 5,
    .parameter = {{"coefficient", 0.0, 0.6, 0.1, 0, 0.0},
                  {"rotor_share", 0.0, 1.0, 1.0, TL_DEFAULT(1.0)},
                  {"friction_share", 0.0, 1.0, 0.0, TL_DEFAULT(0.0)},
                  {"exponent", 1.0, 3.0, 1.0,
                   TL_DEFAULT(1.0)}, /* above 1: the coefficient holds at scale_Nm */
                  {"scale_Nm", 1e-6, 10000.0, 1.0, TL_DEFAULT(1.0)},
                  {"own_coefficient", 0.0, 0.6, 0.0, TL_DEFAULT(0.0)}}, /* where it carries itself */
    .law = law,
};
