/* friction_drift.c: friction on its way from cold to warm, first order in time */
#include "effects.h"

#include "talus/math.h"

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double gone = now->t_s > 0.0 ? 1.0 - tl_exp(-now->t_s / shape[0]) : 0.0;

  torque[0] = 0.0;
  friction[0] = gone;
  torque[1] = gone * now->v;
  friction[1] = 0.0;
}

const tl_effect_kind tl_effect_friction_drift = {
    .name = "friction_drift",
    .meaning = "friction that changes over the recording, as a gear warms up",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .dry = 1,
    .needs_load_sensor = 0,
    .strengths = 2,
    .shapes = 1,
    .parameter = {{"coulomb_Nm", -10.0, 10.0, -0.3},
                  {"viscous_Nms_rad", -100.0, 100.0, -0.1},
                  {"time_constant_s", 5.0, 2000.0, 60.0}},
    .law = law,
};
