/* directional_efficiency.c: a share of the load is lost, another share when the load drives the motor (screws, worm gears) */
#include "../effect_kinds.h"

#include <math.h>

enum { DRIVING, BACK_DRIVING, STRENGTHS };
static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double load = tl_effect_load(now, shape);
  int driving = load * now->slip > 0.0;

  load = fabs(load);
  torque[DRIVING] = torque[BACK_DRIVING] = 0.0;
  friction[DRIVING] = driving ? load : 0.0;
  friction[BACK_DRIVING] = driving ? 0.0 : load;
}

static tl_status numbers(const tl_effect *e, tl_effect_numbers *to) {
  if (!tl_effect_load_is_plain(e)) return TL_ERR_UNSUPPORTED;
  to->driving = e->value[DRIVING];
  to->back_driving = e->value[BACK_DRIVING];
  return TL_OK;
}

const tl_effect_kind tl_effect_directional_efficiency = {
    .name = "directional_efficiency",
    .order = 70,
    .meaning = "losses in proportion to power that differ between driving and back-driving",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .dry = 1,
    .needs_load_sensor = 0,
    .rotor_share = STRENGTHS + TL_LOAD_ROTOR,
    .strengths = STRENGTHS,
    .shapes = TL_LOAD_SHAPES,
    .parameter = {[DRIVING] = {"driving", 0.0, 0.6, 0.15, 0, 0.0},
                  [BACK_DRIVING] = {"back_driving", 0.0, 0.6, 0.05, 0, 0.0},
                  [STRENGTHS + TL_LOAD_ROTOR] = {"rotor_share", 0.0, 1.0, 1.0, TL_DEFAULT(1.0)},
                  [STRENGTHS + TL_LOAD_FRICTION] = {"friction_share", 0.0, 1.0, 0.0, TL_DEFAULT(0.0)},
                  [STRENGTHS + TL_LOAD_OFFSET] = {"offset_share", 0.0, 1.0, 0.0, TL_DEFAULT(0.0)}},
    .law = law,
    .fast = TL_FAST_NUMBERS,
    .numbers = numbers,
};
