/* effect_columns.c: see along.h and link.h. */
#include "effect_columns.h"

#include <math.h>
#include <string.h>

#include "kinematics_stops.h"
#include "talus/math.h"

#define SMALL 1e-5    /* [rad]: step of the slopes of the inverse dynamics */
#define FEWEST_ROWS 5 /* of a window of second order */

size_t tl_effect_stretch_work(size_t n) {
  return 4 * n + tl_reconstruct_workspace(n < TL_WINDOW_MAX_SAMPLES ? n : TL_WINDOW_MAX_SAMPLES);
}

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

void tl_columns_copy(double *column, const double *from, size_t n) {
  memcpy(column, from, n * sizeof *column);
}

void tl_columns_motion(const tl_effect_stretch *s, size_t i, tl_motion *now) {
  int j;

  memset(now, 0, sizeof *now);
  for (j = 0; j < tl_joint_count(s->model); j++) {
    now->q[j] = s->q[j][i];
    now->v[j] = s->v[j][i];
    now->a[j] = s->a[j][i];
    now->slip[j] = s->slip[j][i];
  }
}

void tl_columns_plain_torque(const tl_effect_stretch *s, int joint, double *torque) {
  double at_once[TL_MAX_JOINTS];
  tl_motion now;
  size_t i;

  for (i = 0; i < s->n; i++) {
    tl_columns_motion(s, i, &now);
    tl_inverse(s->model, &now, at_once);
    tl_joint_torque(s->model, now.q, at_once, at_once);
    torque[i] = at_once[joint];
  }
}

void tl_columns_load(const tl_effect_stretch *s, const tl_model *link, int joint, double *load) {
  tl_effect_stretch of_link = *s;

  of_link.model = link;
  tl_columns_plain_torque(&of_link, joint, load);
}

/* ---- slopes of the inverse dynamics ---------------------------------------------- */

static double torque_beside(const tl_model *m, const tl_motion *now, int moved, const double d[3],
                            double step, int shows) {
  tl_motion beside = *now;
  double torque[TL_MAX_JOINTS];

  beside.q[moved] += step * d[0];
  beside.v[moved] += step * d[1];
  beside.a[moved] += step * d[2];
  tl_inverse(m, &beside, torque);
  return torque[shows];
}

/* change of a joint's torque by a shift d of a joint */
static double slope_of(const tl_model *m, const tl_motion *now, int moved, const double d[3], double step,
                       int shows) {
  double more = torque_beside(m, now, moved, d, step, shows),
         less = torque_beside(m, now, moved, d, -step, shows);

  return (more - less) * (0.5 / step);
}

void tl_columns_shift(const tl_effect_stretch *s, const tl_model *m, int moved, double *const *shift,
                      int shows, double *column) {
  double ratio[TL_MAX_JOINTS], unit[TL_MAX_JOINTS] = {1.0, 1.0};
  tl_motion now;
  size_t i;

  for (i = 0; i < s->n; i++) {
    const double d[3] = {shift[0][i], shift[1][i], shift[2][i]};
    double size = fabs(d[0]) + 0.1 * fabs(d[1]), step = size > SMALL ? SMALL / size : 1.0;
    tl_columns_motion(s, i, &now);
    tl_joint_torque(m, now.q, unit, ratio);
    column[i] = slope_of(m, &now, moved, d, step, shows) * ratio[shows];
  }
}

int tl_columns_sees(int joint, int shows) {
  return shows >= TL_MAX_JOINTS && (shows == TL_EFFECT_SHOWS_SHANK) == (joint == 0);
}

void tl_columns_displaced(const tl_effect_stretch *s, const tl_model *link, int joint, double *const *shift,
                          int shows, double *column) {
  tl_columns_nothing(column, s->n);
  if (shows < TL_MAX_JOINTS)
    tl_columns_shift(s, link, joint, shift, shows, column);
  else if (tl_columns_sees(joint, shows))
    tl_columns_copy(column, shift[0], s->n);
}

/* Rates of shift[0] over rows [begin, end) as the window gives them, if it reaches. */
static void piece_as_recorded(const tl_effect_stretch *s, int joint, double *const shift[4], size_t begin,
                              size_t end, int edges) {
  size_t room = s->n < TL_WINDOW_MAX_SAMPLES ? s->n : TL_WINDOW_MAX_SAMPLES;
  tl_status status;

  if (end < begin + FEWEST_ROWS) return;
  status = tl_reconstruct_piece(s->window[joint], s->t_s + begin, shift[0] + begin, end - begin, edges, NULL,
                                shift[1] + begin, shift[2] + begin, s->work + 4 * s->n,
                                tl_reconstruct_workspace(room));
  (void)status; /* too short for a window: the exact rates stand */
}

/* A fast wave moves the motor against it: what is left of both is small beside each, and comes out right only if both
 * lose the same to the window, between the same stops. */
static void as_recorded(const tl_effect_stretch *s, int joint, double *const shift[4]) {
  size_t begin = 0, k;

  if (!s->window[joint]) return;
  for (k = 0; k < s->stops[joint]; k++) {
    const tl_stop *stop = &s->stop[joint][k];
    if (stop->before != TL_NO_ROW)
      piece_as_recorded(s, joint, shift, begin, stop->before + 1,
                        tl_edges_of_piece(k ? stop - 1 : NULL, stop, s->t_s));
    if (stop->after == TL_NO_ROW) return;
    begin = stop->after;
  }
  piece_as_recorded(s, joint, shift, begin, s->n,
                    tl_edges_of_piece(k ? &s->stop[joint][k - 1] : NULL, NULL, s->t_s));
}

void tl_columns_wave(const tl_effect_stretch *s, int joint, double order, int k, double *const shift[4]) {
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
  as_recorded(s, joint, shift);
}

void tl_columns_bridge(const tl_effect_stretch *s, int joint, double *column) {
  tl_bridge_stops(s->stop[joint], s->stops[joint], s->t_s, s->n, column);
}

void tl_columns_rates(const tl_effect_stretch *s, double *const *shift) {
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

/* The particular solution of a straight load is straight too, and what is left swings and decays: exact for any h. */
void tl_columns_swing(const tl_columns_spring *p, double from, double to, double h, double *x, double *v) {
  double w = sqrt(p->stiffness / p->inertia), decay = 0.5 * p->damping / p->inertia;
  double rate = -(to - from) / (h * p->stiffness), lag = rate * p->damping / p->stiffness;
  double end = -to / p->stiffness - lag, swing, a, b, sine, cosine, gone;

  decay = decay < 0.999 * w ? decay : 0.999 * w; /* beyond, it creeps faster than rows follow */
  swing = sqrt(w * w - decay * decay);
  a = *x + from / p->stiffness + lag;
  b = (*v - rate + decay * a) / swing;
  tl_sincos(swing * h, &sine, &cosine);
  gone = tl_exp(-decay * h);
  *x = end + gone * (a * cosine + b * sine);
  *v = rate + gone * ((b * swing - decay * a) * cosine - (a * swing + decay * b) * sine);
}
