/* presliding.c: friction as a spring over a small travel before it slides (Dahl, "A solid friction model", 1968) */
#include "../effect_columns.h"

#include "talus/experimental/hysteresis.h"

enum { FRICTION, STRENGTHS };
enum { TRAVEL, POWER, SHAPES };

static void change(const double *value, tl_effect_change *to) {
  to->memory_Nm += value[FRICTION];
  to->travel_rad = value[STRENGTHS + TRAVEL];
  to->memory_power = value[STRENGTHS + POWER];
}

/* So much of the friction follows z, z' = v (1 - z sgn v)^power / travel, in the place of the slip's sign.
 * z depends on the path alone, and is stepped in closed form. */
static void columns(tl_effect_prepared *p, int joint, const double *shape, const tl_effect_wanted *wanted) {
  const tl_effect_segment *s = p->segment;
  double *column = tl_columns_of(p, wanted, joint, FRICTION);
  size_t i;

  if (!column) return;
  tl_dahl_along(s->q[joint], s->n, shape[TRAVEL], shape[POWER], s->slip[joint][0], column);
  for (i = 0; i < s->n; i++) column[i] -= s->slip[joint][i];
}

const tl_effect_kind tl_effect_presliding = {
    .name = "presliding",
    .order = 190,
    .meaning = "friction that acts like a spring over a small travel after a reversal",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_CHANGE,
    .once = 1,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter = {[FRICTION] = {"friction_Nm", 0.0, 200.0, 0.6, 0, 0.0},
                  [STRENGTHS + TRAVEL] = {"travel_rad", 1e-5, 0.2, 0.005, 0, 0.0},
                  [STRENGTHS + POWER] = {"power", 1.0, 2.0, 1.0, TL_DEFAULT(1.0)}},
    .change = change,
    .columns = columns,
    .memory_s = 4.0,
};
