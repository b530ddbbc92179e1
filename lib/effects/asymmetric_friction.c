/* asymmetric_friction.c: friction with two values, one a direction (Armstrong-Helouvry 1991) */
#include "../effect_kinds.h"

#include <math.h>

enum { COULOMB, VISCOUS, STRENGTHS };

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  (void)shape;
  /* half the difference between the directions: F+ = F + d, F- = F - d */
  torque[COULOMB] = 0.0;
  friction[COULOMB] = now->slip;
  torque[VISCOUS] = fabs(now->v);
  friction[VISCOUS] = 0.0;
}

static tl_status numbers(const tl_effect *e, tl_effect_numbers *to) {
  to->asymmetry_Nm = e->value[COULOMB];
  to->asymmetry_Nms_rad = e->value[VISCOUS];
  return TL_OK;
}

const tl_effect_kind tl_effect_asymmetric_friction = {
    .name = "asymmetric_friction",
    .order = 30,
    .meaning = "Coulomb or viscous friction that differs between the two directions",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_MECHANICAL,
    .dry = 1,
    .needs_load_sensor = 0,
    .strengths = STRENGTHS,
    .shapes = 0,
    .parameter = {[COULOMB] = {"coulomb_Nm", -100.0, 100.0, 0.2, 0, 0.0},
                  [VISCOUS] = {"viscous_Nms_rad", -1000.0, 1000.0, 0.1, 0, 0.0}},
    .law = law,
    .fast = TL_FAST_NUMBERS,
    .numbers = numbers,
};
