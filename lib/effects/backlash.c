/* backlash.c: lost motion between motor and joint: a dead zone before the teeth meet */
#include "along.h"

#define DAMPING_S 1e-3 /* of the teeth in contact: their damping over their stiffness */

static void change(const double *value, tl_effect_change *to) {
  if (!(value[0] * value[1] > 0.0)) return;
  to->gap_rad += value[0] * value[1];
  to->compliance_rad_Nm += 1.0 / value[2];
  if (DAMPING_S > to->damping_s) to->damping_s = DAMPING_S;
}

/* the joint swings between the teeth under the load of its motor's motion, half the gap to each side */
static void along(const tl_effect_stretch *s, int joint, const double *shape, int shows, double *column) {
  double *shift[4] = {s->work, s->work + s->n, s->work + 2 * s->n, s->work + 3 * s->n};
  tl_model link = tl_effect_link_model(s->model, joint);

  tl_along_link(s, &link, joint, shape[1], DAMPING_S, shape[0], shift);
  tl_along_twist(s, &link, joint, shift, shows, column);
}

const tl_effect_kind tl_effect_backlash = {
    .name = "backlash",
    .meaning = "lost motion between motor and joint when the torque reverses",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_CHANGE,
    .strengths = 1,
    .shapes = 2,
    .parameter = {{"share", 0.0, 2.0, 1.0}, /* of the lost motion; 1 for what the gap says */
                  {"gap_rad", 1e-4, 0.1, 0.004},
                  {"stiffness_Nm_rad", 100.0, 100000.0, 3000.0}},
    .change = change,
    .along = along,
    .memory_s = 0.5,
};
