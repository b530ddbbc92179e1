/* directional_efficiency.c: a share of the load is lost, another share when the load drives the motor (screws, worm gears) */
#include "../effect_kinds.h"

#include <math.h>

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double load = tl_effect_load(now, shape[0], shape[1]);
  int driving = load * now->slip > 0.0;

  load = fabs(load);
  torque[0] = torque[1] = 0.0;
  friction[0] = driving ? load : 0.0;
  friction[1] = driving ? 0.0 : load;
}

const tl_effect_kind tl_effect_directional_efficiency = {
    .name = "directional_efficiency",
    .order = 70,
    .meaning = "losses in proportion to power that differ between driving and back-driving",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .dry = 1,
    .needs_load_sensor = 0,
    .rotor_share = 2,
    .strengths = 2,
    .shapes = 2,
    .parameter = {{"driving", 0.0, 0.6, 0.15, 0, 0.0},
                  {"back_driving", 0.0, 0.6, 0.05, 0, 0.0},
                  {"rotor_share", 0.0, 1.0, 1.0, TL_DEFAULT(1.0)},
                  {"friction_share", 0.0, 1.0, 0.0, TL_DEFAULT(0.0)}},
    .law = law,
};
