/* directional_efficiency.c: a share of the load is lost, another share when the load drives the motor (screws, worm gears) */
#include "effects.h"

#include <math.h>

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double load = fabs(now->load_Nm);
  int driving = now->load_Nm * now->slip > 0.0;

  (void)shape;
  torque[0] = torque[1] = 0.0;
  friction[0] = driving ? load : 0.0;
  friction[1] = driving ? 0.0 : load;
}

const tl_effect_kind tl_effect_directional_efficiency = {
    .name = "directional_efficiency",
    .meaning = "losses in proportion to power that differ between driving and back-driving",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .dry = 1,
    .needs_load_sensor = 0,
    .strengths = 2,
    .shapes = 0,
    .parameter = {{"driving", 0.0, 0.6, 0.15}, {"back_driving", 0.0, 0.6, 0.05}},
    .law = law,
};
