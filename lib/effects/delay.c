/* delay.c: currents that are sampled later than the angles, or both later than a sensor at the output */
#include "../effect_columns.h"

enum { DELAY, STRENGTHS };
enum { ANGLES_TOO, NEAR, SHAPES };

static void change(const double *value, tl_effect_change *to) {
  if (value[STRENGTHS + ANGLES_TOO] == 0.0)
    to->delay_s += value[DELAY];
  else
    to->telemetry_delay_s += value[DELAY];
}

/* x at an instant, between the rows about it; the ends hold. *at is where the last one was found. */
static double value_at(const double *t_s, const double *x, size_t n, double when_s, size_t *at) {
  while (*at > 0 && t_s[*at] > when_s) (*at)--;
  while (*at + 1 < n && t_s[*at + 1] <= when_s) (*at)++;
  if (*at + 1 == n || when_s <= t_s[*at]) return x[*at];
  return x[*at] + (when_s - t_s[*at]) / (t_s[*at + 1] - t_s[*at]) * (x[*at + 1] - x[*at]);
}

/* change of x per second of delay: by its slope, or as a secant to a delay */
static double late(const tl_effect_segment *s, const double *x, size_t i, double delay_s, size_t *at) {
  size_t before = i > 0 ? i - 1 : 0, after = i + 1 < s->n ? i + 1 : i;

  if (delay_s == 0.0) return (x[before] - x[after]) / (s->t_s[after] - s->t_s[before]);
  return (value_at(s->t_s, x, s->n, s->t_s[i] - delay_s, at) - x[i]) / delay_s;
}

/* torque(t - delay) = torque(t) - delay torque'; a late input tells of an earlier instant, and beside a sensor the drive's
 * torque is one */
static void columns(tl_effect_prepared *p, int joint, const double *shape, const tl_effect_wanted *wanted) {
  const tl_effect_segment *s = p->segment;
  const double *motor = tl_columns_motor_torque(p, joint), *ratio = p->ratio[joint];
  double *column = tl_columns_of(p, wanted, joint, DELAY), *late_Nm = p->work;
  size_t i, at = 0;

  if (!column || s->n < 2 || (shape[ANGLES_TOO] != 0.0 && !s->effort_Nm)) return;
  for (i = 0; i < s->n; i++) late_Nm[i] = motor[i];
  for (i = 0; s->effort_Nm && i < s->n; i++)
    late_Nm[i] = shape[ANGLES_TOO] == 0.0 ? s->effort_Nm[i] : s->effort_Nm[i] - ratio[i] * motor[i];
  for (i = 0; i < s->n; i++)
    column[i] = s->effort_Nm ? late(s, late_Nm, i, -shape[NEAR], &at)
                             : ratio[i] * late(s, late_Nm, i, shape[NEAR], &at);
}

const tl_effect_kind tl_effect_delay = {
    .name = "delay",
    .order = 160,
    .meaning = "currents and angles sampled at different instants",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_CHANGE,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter = {[DELAY] = {"delay_s", -0.02, 0.02, 0.004, 0, 0.0}, /* positive: the current is later */
                  /* 1: the angles, too, which only a sensor at the output tells */
                  [STRENGTHS + ANGLES_TOO] = {"angles_too", 0.0, 1.0, 0.0, TL_FIT_ONLY(0.0)},
                  /* the delay that the column is a secant to; 0: the slope. Of the fit alone. */
                  [STRENGTHS + NEAR] = {"near_s", -0.02, 0.02, 0.0, TL_DEFAULT(0.0)}},
    .change = change,
    .columns = columns,
    .memory_s = 0.02,
    .bridged = 1,
    .exact = 1,
};
