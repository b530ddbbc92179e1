/* base_compliance.c: a mount that turns under the knee's torque, or sways or rises under the leg's forces */
#include "../effect_columns.h"

#include <string.h>

#include "talus/math.h"

static void change(const double *value, tl_effect_change *to) {
  to->base_compliance_rad_Nm += value[0];
  to->base_hz = value[3];
  to->base_share = value[4];
}

/* moments of shank and foot [kg m], each times the sine and the cosine of its absolute angle */
typedef struct moments {
  double shank[2], foot[2];
} moments;

static moments moments_at(const tl_effect_stretch *s, const tl_model *weightless, size_t i) {
  tl_motion now, still;
  double torque[TL_MAX_JOINTS];
  moments m;

  tl_columns_motion(s, i, &now);
  memset(&still, 0, sizeof still);
  memcpy(still.q, now.q, sizeof still.q);
  tl_inverse(weightless, &still, torque);
  m.foot[0] = torque[1];
  m.shank[0] = torque[0] - torque[1];
  m.foot[1] = tl_effect_tilt_of(weightless, &now, 1);
  m.shank[1] = tl_effect_tilt_of(weightless, &now, 0) - m.foot[1];
  return m;
}

/* of both links' inertia on the mount, to the front or (`up`) upwards */
static double force_on_mount(const tl_effect_stretch *s, const moments *m, int up, size_t i) {
  double v = s->v[0][i], foot_v = v + s->v[1][i], a = s->a[0][i], foot_a = a + s->a[1][i];
  double side = up ? 1.0 : -1.0; /* a link's end goes on a circle: r sin q to the front, -r cos q upwards */

  return m->shank[!up] * a + side * m->shank[up] * v * v + m->foot[!up] * foot_a +
         side * m->foot[up] * foot_v * foot_v;
}

/* x'' + 2 d w x' + w^2 x = -w^2 drive, from drive in shift[2]: x in shift[0], its rates in the others */
static void swing(const tl_effect_stretch *s, double w, double share, double *const shift[3]) {
  tl_columns_spring spring = {1.0 / (w * w), 1.0, 2.0 * share / w};
  double x = 0.0, v = 0.0, before = 0.0, drive;
  size_t i;

  for (i = 0; i < s->n; i++) {
    drive = shift[2][i];
    if (i == 0) x = -drive;
    if (i > 0) tl_columns_swing(&spring, before, drive, s->t_s[i] - s->t_s[i - 1], &x, &v);
    before = drive;
    shift[0][i] = x;
    shift[1][i] = v;
    shift[2][i] = -w * w * (drive + x + spring.damping * v);
  }
}

/* The knee's torque turns the mount back, w with the leg hanging from it. The sway adds to every absolute angle,
 * as if the knee had moved. */
static void turn(const tl_effect_stretch *s, const tl_model *bare, const double *shape, int shows,
                 double *column) {
  double *shift[3] = {s->work, s->work + s->n, s->work + 2 * s->n};

  tl_columns_nothing(column, s->n);
  tl_columns_load(s, bare, 0, shift[2]);
  swing(s, 2.0 * TL_PI * shape[0], shape[1], shift);
  if (shows < TL_MAX_JOINTS) tl_columns_shift(s, bare, 0, shift, shows, column);
  if (shows == TL_EFFECT_SHOWS_SHANK) tl_columns_copy(column, shift[0], s->n);
}

/* the mount's acceleration is one more gravity, across the first or (`up`) along it */
static void move(const tl_effect_stretch *s, const tl_model *bare, const double *shape, int up, int shows,
                 double *column) {
  double *shift[3] = {s->work, s->work + s->n, s->work + 2 * s->n};
  tl_model weightless = *bare;
  moments m;
  size_t i;

  tl_columns_nothing(column, s->n);
  if (shows >= TL_MAX_JOINTS) return;
  weightless.gravity_m_s2 = 1.0;
  for (i = 0; i < s->n; i++) {
    m = moments_at(s, &weightless, i);
    shift[2][i] = force_on_mount(s, &m, up, i);
    column[i] = m.foot[!up] + (shows == 0 ? m.shank[!up] : 0.0);
  }
  swing(s, 2.0 * TL_PI * shape[0], shape[1], shift);
  for (i = 0; i < s->n; i++) column[i] *= shift[2][i];
}

static void along(const tl_effect_stretch *s, int joint, const double *shape, int shows, double *column) {
  tl_model bare = tl_effect_bare_model(s->model);

  (void)joint;
  turn(s, &bare, shape, shows, column);
  move(s, &bare, shape, 0, shows, column + s->n);
  move(s, &bare, shape, 1, shows, column + 2 * s->n);
}

const tl_effect_kind tl_effect_base_compliance = {
    .name = "base_compliance",
    .order = 220,
    .meaning = "the mount turns, sways or rises on its own spring",
    .places = TL_EFFECT_AT_BASE,
    .acts = TL_EFFECT_CHANGE,
    .strengths = 3,
    .shapes = 2,
    .parameter = {{"compliance_rad_Nm", 0.0, 0.05, 0.001, 0, 0.0},
                  {"sway_m_N", 0.0, 0.05, 0.0, TL_FIT_ONLY(0.0)},
                  {"rise_m_N", 0.0, 0.05, 0.0, TL_FIT_ONLY(0.0)},
                  {"frequency_Hz", 1.0, 40.0, 8.0, 0, 0.0},
                  {"damping_ratio", 0.005, 1.0, 0.05, 0, 0.0}},
    .change = change,
    .along = along,
    .memory_s = 1.5,
};
