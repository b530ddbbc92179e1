/* reference.c: see reference.h. */
#include "reference.h"

#include <math.h>
#include <string.h>

#define BASE_HZ 1.0 /* slow against a sample's step: the series is then a parabola */

void reference_rest(const struct trajectory *t, tl_excitation *e) {
  tl_motion start;

  trajectory_at(t, 0.0, &start);
  memset(e, 0, sizeof *e);
  e->kind = TL_EXCITATION_RAMPS;
  e->joints = t->joints;
  e->base_hz = BASE_HZ;
  e->moves = 1;
  e->move[0].duration_s = 1.0;
  for (int j = 0; j < t->joints; j++) e->offset[j] = start.q[j];
}

/* q + v sin(w x) / w + a (1 - cos(w x)) / w^2 with x from `middle_s`, as a series in time */
static void lay_joint(tl_excitation *e, int joint, const tl_motion *at, double middle_s) {
  const double w = 2.0 * acos(-1.0) * BASE_HZ, sine = sin(w * middle_s), cosine = cos(w * middle_s);
  const double along = at->v[joint] / w, across = -at->a[joint] / (w * w);

  e->offset[joint] = at->q[joint] - across;
  e->sine[joint][0] = along * cosine + across * sine;
  e->cosine[joint][0] = across * cosine - along * sine;
}

void reference_lay(const struct trajectory *t, const tl_twin *b, tl_excitation *e) {
  const double middle_s = ((double)b->sample - 0.5) / b->settings.sample_hz;
  tl_motion at;

  if (b->sample == 0) return; /* still at rest */
  e->kind = TL_EXCITATION_FOURIER;
  e->harmonics = 1;
  trajectory_at(t, middle_s, &at);
  for (int j = 0; j < t->joints; j++) lay_joint(e, j, &at, b->settings.settle_s + middle_s);
}

/* ---- limits ------------------------------------------------------------------------ */

static void note_peak(tl_peak *p, double value, double t_s) {
  const int low = p->quantity == TL_QUANTITY_POSITION_LOW, high = p->quantity == TL_QUANTITY_POSITION_HIGH;
  const double excess = low ? p->limit - value : high ? value - p->limit : fabs(value) - p->limit;

  if (!(excess > p->excess)) return;
  p->peak = value;
  p->excess = excess;
  p->t_s = t_s;
}

static void begin_peaks(const tl_limits *limit, int joint, tl_peak peak[TL_QUANTITIES]) {
  const double value[TL_QUANTITIES] = {limit->position_low, limit->position_high, limit->speed,
                                       limit->acceleration, limit->torque};

  for (int k = 0; k < TL_QUANTITIES; k++)
    peak[k] =
        (tl_peak){.joint = joint, .quantity = (tl_quantity)k, .limit = value[k], .excess = -(double)INFINITY};
}

static void note_row(const tl_model *m, const struct trajectory *t, double t_s, tl_peak peak[TL_MAX_PEAKS]) {
  double torque[TL_MAX_JOINTS];
  tl_motion at;

  trajectory_at(t, t_s, &at);
  tl_slip_from_velocity(m, &at);
  tl_inverse(m, &at, torque);
  for (int j = 0; j < t->joints; j++) {
    const double value[TL_QUANTITIES] = {at.q[j], at.q[j], at.v[j], at.a[j], torque[j]};
    for (int k = 0; k < TL_QUANTITIES; k++) note_peak(&peak[j * TL_QUANTITIES + k], value[k], t_s);
  }
}

int reference_check(const tl_model *m, const tl_limits limits[TL_MAX_JOINTS], const struct trajectory *t,
                    tl_peak peak[TL_MAX_PEAKS]) {
  tl_peak every[TL_MAX_PEAKS] = {{0}};
  int broken = 0;

  for (int j = 0; j < t->joints; j++) begin_peaks(&limits[j], j, every + j * TL_QUANTITIES);
  for (size_t i = 0; i < t->rows; i++) note_row(m, t, t->t_s[i], every);
  for (int k = 0; k < t->joints * TL_QUANTITIES; k++)
    if (every[k].excess > 0.0) peak[broken++] = every[k];
  return broken;
}
