/* presliding.c: friction as a spring over a small travel before it slides (Dahl 1968) */
#include "along.h"

#include <math.h>

#include "talus/math.h"

static void change(const double *value, tl_effect_change *to) {
  to->memory_Nm += value[0];
  to->travel_rad = value[1];
}

/* So much of the friction follows z, z' = v (1 - z sgn v) / travel, in the place of the slip's sign.
 * z depends on the path alone: over a piece dq it nears the sign of dq by exp(-abs(dq) / travel). */
static void along(const tl_effect_stretch *s, int joint, const double *shape, int shows, double *column) {
  double z;
  size_t i;

  tl_along_nothing(column, s->n);
  if (shows != joint || s->n == 0) return;
  z = s->slip[joint][0];
  for (i = 0; i < s->n; i++) {
    double way = i ? s->q[joint][i] - s->q[joint][i - 1] : 0.0, end = way < 0.0 ? -1.0 : 1.0;
    z = end + (z - end) * tl_exp(-fabs(way) / shape[0]);
    column[i] = z - s->slip[joint][i];
  }
}

const tl_effect_kind tl_effect_presliding = {
    .name = "presliding",
    .meaning = "friction that acts like a spring over a small travel after a reversal",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_CHANGE,
    .strengths = 1,
    .shapes = 1,
    .parameter = {{"friction_Nm", 0.0, 50.0, 0.6}, {"travel_rad", 1e-4, 0.2, 0.005}},
    .change = change,
    .along = along,
    .memory_s = 0.5,
};
