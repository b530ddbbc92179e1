/* delay.c: currents that are sampled later than the angles, or both later than a sensor at the output */
#include "../effect_columns.h"

static void change(const double *value, tl_effect_change *to) {
  if (value[1] == 0.0)
    to->delay_s += value[0];
  else
    to->telemetry_delay_s += value[0];
}

static void slope(const double *t_s, const double *x, size_t n, double factor, double *out) {
  size_t i;

  for (i = 1; i + 1 < n; i++) out[i] = factor * (x[i + 1] - x[i - 1]) / (t_s[i + 1] - t_s[i - 1]);
  out[0] = out[1];
  out[n - 1] = out[n - 2];
}

/* torque(t - delay) = torque(t) - delay torque'; a late input tells of an earlier instant, and beside a sensor the drive's
 * torque is one */
static void along(const tl_effect_stretch *s, int joint, const double *shape, int shows, double *column) {
  size_t i;

  tl_columns_nothing(column, s->n);
  if (shows != joint || s->n < 3 || (shape[0] != 0.0 && !s->effort_Nm)) return;
  if (s->effort_Nm && shape[0] == 0.0) {
    slope(s->t_s, s->effort_Nm, s->n, -1.0, column);
    return;
  }
  tl_columns_plain_torque(s, joint, s->work);
  for (i = 0; s->effort_Nm && i < s->n; i++) s->work[i] -= s->effort_Nm[i];
  slope(s->t_s, s->work, s->n, s->effort_Nm ? 1.0 : -1.0, column);
}

const tl_effect_kind tl_effect_delay = {
    .name = "delay",
    .order = 160,
    .meaning = "currents and angles sampled at different instants",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_CHANGE,
    .strengths = 1,
    .shapes = 1,
    .parameter = {{"delay_s", -0.02, 0.02, 0.004, 0, 0.0}, /* positive: the current is later */
                  /* 1: the angles, too, which only a sensor at the output tells */
                  {"angles_too", 0.0, 1.0, 0.0, TL_FIT_ONLY(0.0)}},
    .change = change,
    .along = along,
    .memory_s = 0.02,
    .exact = 1,
};
