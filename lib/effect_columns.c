/* effect_columns.c: see effect_columns.h. */
#include "effect_columns.h"

#include <math.h>
#include <string.h>

#include "talus/math.h"

#define SMALL 1e-5    /* [rad]: step of the slopes of the inverse dynamics */
#define FEWEST_ROWS 5 /* of a window of second order */

/* ---- models ------------------------------------------------------------------ */

static void make_rigid(tl_transmission *t) {
  t->kind = TL_TRANSMISSION_FIXED;
  t->ratio = 1.0;
}

tl_model tl_effect_bare_model(const tl_model *m) {
  tl_model bare = *m;
  int j;

  for (j = 0; j < TL_MAX_JOINTS; j++) {
    bare.drive[j].coulomb_Nm = bare.drive[j].viscous_Nms_rad = 0.0;
    make_rigid(&bare.drive[j].transmission);
    bare.drive[j].rotor_inertia_kg_m2 = 0.0;
  }
  tl_clear_offsets(&bare);
  return bare;
}

tl_status tl_effect_change_linkage(const tl_effect_change *c, const tl_transmission *t,
                                   tl_transmission *changed) {
  tl_screw_linkage linkage = t->linkage;

  *changed = *t;
  if (c->AB_m == 0.0 && c->BO_m == 0.0 && c->AC_m == 0.0 && c->BOF_rad == 0.0) return TL_OK;
  if (t->kind != TL_TRANSMISSION_SCREW_LINKAGE) return TL_ERR_UNSUPPORTED;
  linkage.AB_m += c->AB_m;
  linkage.BO_m += c->BO_m;
  linkage.AC_m += c->AC_m;
  linkage.BOF_deg += c->BOF_rad * (180.0 / TL_PI);
  return tl_transmission_screw_linkage(changed, &linkage);
}

/* ---- rows -------------------------------------------------------------------- */

void tl_columns_nothing(double *column, size_t n) {
  size_t i;

  for (i = 0; i < n; i++) column[i] = 0.0;
}

double *tl_columns_of(const tl_effect_prepared *p, const tl_effect_wanted *wanted, int channel,
                      int strength) {
  if (!wanted->shown[channel] || !tl_columns_wants(wanted, 1u << strength)) return NULL;
  return wanted->shown[channel] + (size_t)strength * p->segment->n;
}

int tl_columns_wants(const tl_effect_wanted *wanted, unsigned strengths) {
  return (wanted->strengths & strengths) != 0;
}

void tl_columns_motion(const tl_effect_segment *s, size_t i, tl_motion *now) {
  int j;

  memset(now, 0, sizeof *now);
  for (j = 0; j < tl_joint_count(s->model); j++) {
    now->q[j] = s->q[j][i];
    now->v[j] = s->v[j][i];
    now->a[j] = s->a[j][i];
    now->slip[j] = s->slip[j][i];
  }
}

/* ---- what a displaced joint shows ---------------------------------------------------- */

int tl_columns_sees(int joint, int channel) {
  return channel >= TL_MAX_JOINTS && (channel == TL_EFFECT_SHOWS_SHANK) == (joint == 0);
}

void tl_columns_add_shift(tl_effect_prepared *p, int moved, double *const *shift, int joint, double *column) {
  double *const *slope = tl_columns_slopes(p, moved, joint);
  size_t i;

  for (i = 0; i < p->segment->n; i++)
    column[i] += slope[0][i] * shift[0][i] + slope[1][i] * shift[1][i] + slope[2][i] * shift[2][i];
}

/* where an angle between joint and motor is seen */
static void add_seen(const tl_effect_prepared *p, int joint, const double *angle, int strength,
                     const tl_effect_wanted *wanted) {
  double *column;
  size_t i;
  int c;

  for (c = TL_MAX_JOINTS; c < TL_EFFECT_CHANNELS; c++) {
    column = tl_columns_sees(joint, c) ? tl_columns_of(p, wanted, c, strength) : NULL;
    for (i = 0; column && i < p->segment->n; i++) column[i] += angle[i];
  }
}

void tl_columns_displaced(tl_effect_prepared *p, int joint, double *const *shift, int strength,
                          const tl_effect_wanted *wanted) {
  double *column;
  int j;

  for (j = 0; j < tl_joint_count(p->segment->model); j++)
    if ((column = tl_columns_of(p, wanted, j, strength))) tl_columns_add_shift(p, joint, shift, j, column);
  add_seen(p, joint, shift[0], strength, wanted);
}

/* change of every joint's torque by a shift d of one */
static void slopes_along(const tl_model *m, const tl_motion *now, int moved, const double d[3],
                         double slope[TL_MAX_JOINTS]) {
  double size = fabs(d[0]) + 0.1 * fabs(d[1]), step = size > SMALL ? SMALL / size : 1.0;
  double more[TL_MAX_JOINTS], less[TL_MAX_JOINTS];
  tl_motion beside = *now;
  int j;

  beside.q[moved] += step * d[0];
  beside.v[moved] += step * d[1];
  beside.a[moved] += step * d[2];
  tl_inverse(m, &beside, more);
  beside.q[moved] = now->q[moved] - step * d[0];
  beside.v[moved] = now->v[moved] - step * d[1];
  beside.a[moved] = now->a[moved] - step * d[2];
  tl_inverse(m, &beside, less);
  for (j = 0; j < tl_joint_count(m); j++) slope[j] = (more[j] - less[j]) * (0.5 / step);
}

void tl_columns_displaced_whole(tl_effect_prepared *p, int joint, double *const *shift, int strength,
                                const tl_effect_wanted *wanted) {
  const tl_effect_segment *s = p->segment;
  double slope[TL_MAX_JOINTS] = {0.0}, *column;
  tl_motion now;
  size_t i;
  int j;

  for (i = 0; i < s->n; i++) {
    const double d[3] = {shift[0][i], shift[1][i], shift[2][i]};
    tl_columns_motion(s, i, &now);
    slopes_along(s->model, &now, joint, d, slope);
    tl_joint_torque(s->model, now.q, slope, slope);
    for (j = 0; j < tl_joint_count(s->model); j++)
      if ((column = tl_columns_of(p, wanted, j, strength))) column[i] += slope[j];
  }
  add_seen(p, joint, shift[0], strength, wanted);
}

/* Rates of shift[0] over rows [begin, end) as the window gives them, if it reaches. */
static void phase_as_recorded(const tl_effect_prepared *p, int joint, double *const shift[4], size_t begin,
                              size_t end, int edges) {
  const tl_effect_segment *s = p->segment;
  size_t room = s->n < TL_WINDOW_MAX_SAMPLES ? s->n : TL_WINDOW_MAX_SAMPLES;
  tl_status status;

  if (end < begin + FEWEST_ROWS) return;
  status = tl_reconstruct_slip_phase(s->window[joint], s->t_s + begin, shift[0] + begin, end - begin, edges,
                                     NULL, shift[1] + begin, shift[2] + begin, p->work + 4 * s->n,
                                     tl_reconstruct_workspace(room));
  (void)status; /* too short for a window: the exact rates stand */
}

/* A fast wave moves the motor against it: what is left of both is small beside each, and comes out right only if both
 * lose the same to the window, between the same stops. */
static void as_recorded(const tl_effect_prepared *p, int joint, double *const shift[4]) {
  const tl_effect_segment *s = p->segment;
  size_t begin = 0, k;

  if (!s->window[joint]) return;
  for (k = 0; k < s->stops[joint]; k++) {
    const tl_stop *stop = &s->stop[joint][k];
    if (stop->before != TL_NO_ROW)
      phase_as_recorded(p, joint, shift, begin, stop->before + 1,
                        tl_slip_phase_edges(k ? stop - 1 : NULL, stop, s->t_s));
    if (stop->after == TL_NO_ROW) return;
    begin = stop->after;
  }
  phase_as_recorded(p, joint, shift, begin, s->n,
                    tl_slip_phase_edges(k ? &s->stop[joint][k - 1] : NULL, NULL, s->t_s));
}

void tl_columns_wave(const tl_effect_prepared *p, int joint, double order, int k, double *const shift[4]) {
  const tl_effect_segment *s = p->segment;
  const tl_transmission *t = &s->model->drive[joint].transmission;
  double motor, ratio, slope, wave[2], v, a;
  size_t i;

  for (i = 0; i < s->n; i++) {
    motor = tl_transmission_motor_angle(t, s->q[joint][i]);
    tl_transmission_ratio(t, s->q[joint][i], &ratio, &slope);
    v = order * ratio * s->v[joint][i];
    a = order * (ratio * s->a[joint][i] + slope * s->v[joint][i] * s->v[joint][i]);
    tl_sincos(order * motor, &wave[0], &wave[1]);
    shift[0][i] = wave[k];
    shift[1][i] = (k == 0 ? wave[1] : -wave[0]) * v;
    shift[2][i] = (k == 0 ? wave[1] : -wave[0]) * a - wave[k] * v * v;
    shift[3][i] = ratio;
  }
  as_recorded(p, joint, shift);
}

void tl_columns_bridge(const tl_effect_segment *s, int joint, double *column) {
  tl_bridge_stops(s->stop[joint], s->stops[joint], s->t_s, s->n, column);
}

void tl_columns_rates(const tl_effect_segment *s, double *const *shift) {
  const double *x = shift[0], *t = s->t_s;
  size_t i;

  tl_columns_nothing(shift[1], s->n);
  tl_columns_nothing(shift[2], s->n);
  for (i = 1; i + 1 < s->n; i++) {
    double left = t[i] - t[i - 1], right = t[i + 1] - t[i];
    double before = (x[i] - x[i - 1]) / left, after = (x[i + 1] - x[i]) / right;
    shift[1][i] = (before * right + after * left) / (left + right);
    shift[2][i] = 2.0 * (after - before) / (left + right);
  }
}

/* ---- a spring under a load --------------------------------------------------------- */

tl_columns_swing tl_columns_swing_of(tl_columns_spring spring) {
  tl_columns_swing w;
  double fastest =
      0.999 * sqrt(spring.stiffness / spring.inertia); /* beyond, it creeps faster than rows follow */

  memset(&w, 0, sizeof w);
  w.spring = spring;
  w.decay = 0.5 * spring.damping / spring.inertia;
  if (w.decay > fastest) w.decay = fastest;
  w.w2 = spring.stiffness / spring.inertia;
  return w;
}

/* the free motion over h, exactly */
static void set_base(tl_columns_swing *w, double h) {
  double swing = sqrt(w->w2 - w->decay * w->decay), sine, cosine, gone = tl_exp(-w->decay * h);

  tl_sincos(swing * h, &sine, &cosine);
  sine *= gone / swing;
  cosine *= gone;
  w->base_s = h;
  w->turned[0][0] = cosine + w->decay * sine;
  w->turned[0][1] = sine;
  w->turned[1][0] = -w->w2 * sine;
  w->turned[1][1] = cosine - w->decay * sine;
}

/* Free motion over h from (x, v): over base_s, and over the rest d by the series of exp(A d), whose powers are
 * A^2 = -2 decay A - w^2 and so on; what it leaves out is below 1e-9 of the state. */
static void swing_freely(tl_columns_swing *w, double h, double *x, double *v) {
  double d = h - w->base_s, p = 2.0 * w->decay, q = w->w2, own, rate, a, b;

  if (!(w->base_s > 0.0 && d * d * q < 1e-3)) {
    set_base(w, h);
    d = 0.0;
  }
  a = 1.0 - d * d * q * (0.5 - d * (p / 6.0 + d * (q - p * p) / 24.0));
  b = d * (1.0 - d * (0.5 * p - d * ((p * p - q) / 6.0 + d * p * (2.0 * q - p * p) / 24.0)));
  own = a * *x + b * *v;
  rate = a * *v - b * (q * *x + p * *v);
  *x = w->turned[0][0] * own + w->turned[0][1] * rate;
  *v = w->turned[1][0] * own + w->turned[1][1] * rate;
}

/* The particular solution of a straight load is straight too, and what is left swings and decays: exact for any h. */
void tl_columns_swing_on(tl_columns_swing *w, double from, double to, double h, double *x, double *v) {
  double k = w->spring.stiffness, rate = -(to - from) / (h * k), lag = rate * w->spring.damping / k;

  *x += from / k + lag;
  *v -= rate;
  swing_freely(w, h, x, v);
  *x -= to / k + lag;
  *v += rate;
}
