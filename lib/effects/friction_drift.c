/* friction_drift.c: friction on its way from cold to warm, first order in time; or with the temperature itself */
#include "../effect_kinds.h"

#include "talus/math.h"

enum { COULOMB, VISCOUS, COLD_COULOMB, COLD_VISCOUS, COULOMB_10K, VISCOUS_10K, STRENGTHS };
enum { TIME_CONSTANT, MIDDLE, SHAPES };

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  static const int coulomb[3] = {COULOMB, COLD_COULOMB, COULOMB_10K};
  static const int viscous[3] = {VISCOUS, COLD_VISCOUS, VISCOUS_10K};
  double left = now->t_s > 0.0 ? tl_exp(-now->t_s / shape[TIME_CONSTANT]) : 1.0;
  double weight[3] = {1.0 - left, left, (now->temp_C - shape[MIDDLE]) / 10.0};
  int k;

  for (k = 0; k < 3; k++) {
    torque[coulomb[k]] = friction[viscous[k]] = 0.0;
    friction[coulomb[k]] = weight[k];
    torque[viscous[k]] = weight[k] * now->v;
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
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter = {[COULOMB] = {"coulomb_Nm", -100.0, 100.0, -0.3, 0, 0.0}, /* what comes as it warms up */
                  [VISCOUS] = {"viscous_Nms_rad", -1000.0, 1000.0, -0.1, 0, 0.0},
                  /* what goes as it warms up */
                  [COLD_COULOMB] = {"cold_coulomb_Nm", -100.0, 100.0, 0.0, TL_DEFAULT(0.0)},
                  [COLD_VISCOUS] = {"cold_viscous_Nms_rad", -1000.0, 1000.0, 0.0, TL_DEFAULT(0.0)},
                  [COULOMB_10K] = {"coulomb_Nm_10K", -100.0, 100.0, 0.0, TL_NEEDS_TEMPERATURE},
                  [VISCOUS_10K] = {"viscous_Nms_rad_10K", -1000.0, 1000.0, 0.0, TL_NEEDS_TEMPERATURE},
                  [STRENGTHS + TIME_CONSTANT] = {"time_constant_s", 1.0, 2000.0, 60.0, 0, 0.0},
                  [STRENGTHS + MIDDLE] = {"middle_C", -100.0, 300.0, 30.0, TL_DEFAULT(0.0)}},
    .law = law,
    .memory_s = 1.1, /* the temperature is a mean over 2 s */
};
