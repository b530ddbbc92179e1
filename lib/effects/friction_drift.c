/* friction_drift.c: friction on its way from cold to warm, first order in time; or with the temperature itself */
#include "../effect_kinds.h"

#include "talus/math.h"

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double left = now->t_s > 0.0 ? tl_exp(-now->t_s / shape[0]) : 1.0, warmer = (now->temp_C - shape[1]) / 10.0;
  double weight[3] = {1.0 - left, left, warmer};
  int k;

  for (k = 0; k < 3; k++) {
    torque[2 * k] = friction[2 * k + 1] = 0.0;
    friction[2 * k] = weight[k];
    torque[2 * k + 1] = weight[k] * now->v;
  }
}

const tl_effect_kind tl_effect_friction_drift = {
    .name = "friction_drift",
    .order = 60,
    .meaning = "friction that changes over the recording, as a gear warms up",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .dry = 1,
    .needs_load_sensor = 0,
    .strengths = 6,
    .shapes = 2,
    .parameter = {{"coulomb_Nm", -100.0, 100.0, -0.3, 0, 0.0}, /* what comes as it warms up */
                  {"viscous_Nms_rad", -1000.0, 1000.0, -0.1, 0, 0.0},
                  {"cold_coulomb_Nm", -100.0, 100.0, 0.0, TL_DEFAULT(0.0)}, /* what goes as it warms up */
                  {"cold_viscous_Nms_rad", -1000.0, 1000.0, 0.0, TL_DEFAULT(0.0)},
                  {"coulomb_Nm_10K", -100.0, 100.0, 0.0, TL_NEEDS_TEMPERATURE},
                  {"viscous_Nms_rad_10K", -1000.0, 1000.0, 0.0, TL_NEEDS_TEMPERATURE},
                  {"time_constant_s", 1.0, 2000.0, 60.0, 0, 0.0},
                  {"middle_C", -100.0, 300.0, 30.0, TL_DEFAULT(0.0)}},
    .law = law,
    .memory_s = 1.1, /* the temperature is a mean over 2 s */
};
