/* elasticity.c: a transmission that twists in proportion to the load (Spong 1987) */
#include "along.h"

static void change(const double *value, tl_effect_change *to) {
  to->compliance_rad_Nm += value[0] / value[1];
  if (value[2] > to->damping_s) to->damping_s = value[2];
}

/* The joint swings on its spring against its motor, under the load of the motor's motion; its inertia and
 * gravity then are those of that motion, to first order. */
static void along(const tl_effect_stretch *s, int joint, const double *shape, int shows, double *column) {
  double *shift[4] = {s->work, s->work + s->n, s->work + 2 * s->n, s->work + 3 * s->n};
  tl_model link = tl_effect_link_model(s->model, joint);

  tl_along_link(s, &link, joint, shape[0], shape[1], 0.0, shift);
  tl_along_twist(s, &link, joint, shift, shows, column);
}

const tl_effect_kind tl_effect_elasticity = {
    .name = "elasticity",
    .meaning = "torsional compliance between motor and joint",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_CHANGE,
    .strengths = 1,
    .shapes = 2,
    .parameter = {{"share", 0.0, 2.0, 1.0}, /* of the twist; 1 for what the stiffness says */
                  {"stiffness_Nm_rad", 20.0, 100000.0, 1000.0},
                  {"damping_s", 0.0, 0.1, 0.001}},
    .change = change,
    .along = along,
    .memory_s = 0.5,
};
