/* delay.c: currents that are sampled later than the angles */
#include "along.h"

static void change(const double *value, tl_effect_change *to) {
  to->delay_s += value[0];
}

/* torque(t - delay) = torque(t) - delay torque' */
static void along(const tl_effect_stretch *s, int joint, const double *shape, int shows, double *column) {
  size_t i;

  (void)shape;
  if (shows != joint || s->n < 3) {
    tl_along_nothing(column, s->n);
    return;
  }
  tl_along_plain_torque(s, joint, s->work);
  for (i = 1; i + 1 < s->n; i++)
    column[i] = -(s->work[i + 1] - s->work[i - 1]) / (s->t_s[i + 1] - s->t_s[i - 1]);
  column[0] = column[1];
  column[s->n - 1] = column[s->n - 2];
}

const tl_effect_kind tl_effect_delay = {
    .name = "delay",
    .meaning = "currents and angles sampled at different instants",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_CHANGE,
    .strengths = 1,
    .shapes = 0,
    .parameter = {{"delay_s", -0.02, 0.02, 0.004, 0, 0.0}}, /* positive: the current is later */
    .change = change,
    .along = along,
    .memory_s = 0.02,
    .exact = 1,
};
