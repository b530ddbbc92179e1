/* base_compliance.c: a mount that turns under the knee's torque, or sways or rises under the leg's forces */
#include "../effect_columns.h"

#include <string.h>

#include "talus/factor.h"
#include "talus/math.h"

#define BEGIN_SWING 0.5 /* of a swing of the mount: so long what drives it is a parabola */
#define FEWEST_ROWS 5

enum { TURN, SWAY, RISE, STRENGTHS };
enum { FREQUENCY, DAMPING, SHAPES };

static void change(const double *value, tl_effect_change *to) {
  static const tl_mount_mode mode[STRENGTHS] = {
      [TURN] = TL_MOUNT_TURNS, [SWAY] = TL_MOUNT_SWAYS, [RISE] = TL_MOUNT_RISES};
  const double *shape = value + STRENGTHS;
  int k;

  for (k = 0; k < STRENGTHS; k++)
    tl_effect_add_mount(to, mode[k], value[k], shape[FREQUENCY], shape[DAMPING]);
}

/* The parabola a + b t + c t^2 / 2 nearest to a drive over the first span_s of a segment, which begins it; 0 where that has too
 * few rows. */
static int parabola(const tl_effect_segment *s, const double *drive, double span_s, double *a, double *b,
                    double *c) {
  double part, row[4], bend[3];
  tl_factor f;
  size_t i;

  if (tl_factor_init(&f, 3) != TL_OK) return 0;
  for (i = 0; i < s->n && s->t_s[i] - s->t_s[0] <= span_s; i++) {
    part = (s->t_s[i] - s->t_s[0]) / span_s;
    row[0] = 1.0;
    row[1] = part;
    row[2] = 0.5 * part * part;
    row[3] = drive[i];
    tl_factor_add(&f, row, 1, 1);
  }
  if (i < FEWEST_ROWS || tl_factor_solve(&f, 1e-9, bend, NULL) != TL_OK) return 0;
  *a = bend[0];
  *b = bend[1] / span_s;
  *c = bend[2] / (span_s * span_s);
  return 1;
}

/* No segment says how the mount swung before it. It begins as it would under a drive that has always been the parabola of its
 * first BEGIN_SWING of a swing: x'' = -c, and x and x' follow from that. */
static void begin(const tl_effect_segment *s, const double *shape, const double *drive, double *x,
                  double *v) {
  double w = 2.0 * TL_PI * shape[FREQUENCY], lag = 2.0 * shape[DAMPING] / w, a, b, c;

  *x = -drive[0];
  *v = 0.0;
  if (!parabola(s, drive, BEGIN_SWING / shape[FREQUENCY], &a, &b, &c)) return;
  *v = -(b - lag * c);
  *x = c / (w * w) - a - lag * *v;
}

/* x'' + 2 d w x' + w^2 x = -w^2 drive: x in shift[0], its rates in the others */
static void swing(const tl_effect_segment *s, const double *shape, const double *drive,
                  double *const shift[3]) {
  double w = 2.0 * TL_PI * shape[FREQUENCY], x, v;
  tl_columns_spring spring = {1.0 / (w * w), 1.0, 2.0 * shape[DAMPING] / w};
  tl_columns_swing mount = tl_columns_swing_of(spring);
  size_t i;

  begin(s, shape, drive, &x, &v);
  for (i = 0; i < s->n; i++) {
    if (i > 0) tl_columns_swing_on(&mount, drive[i - 1], drive[i], s->t_s[i] - s->t_s[i - 1], &x, &v);
    shift[0][i] = x;
    shift[1][i] = v;
    shift[2][i] = -w * w * (drive[i] + x + spring.damping * v);
  }
}

/* The knee's torque turns the mount back, w with the leg hanging from it. The sway adds to every absolute angle,
 * as if the knee had moved. */
static void turn(tl_effect_prepared *p, const double *shape, double *const shift[3],
                 const tl_effect_wanted *wanted) {
  double *column;
  int j;

  swing(p->segment, shape, tl_columns_load(p, 0), shift);
  for (j = 0; j < tl_joint_count(p->segment->model); j++)
    if ((column = tl_columns_of(p, wanted, j, TURN))) tl_columns_add_shift(p, 0, shift, j, column);
  if ((column = tl_columns_of(p, wanted, TL_EFFECT_SHOWS_SHANK, TURN)))
    memcpy(column, shift[0], p->segment->n * sizeof *column);
}

/* the mount's acceleration is one more gravity, across the first or (`up`) along it */
static void move(tl_effect_prepared *p, const double *shape, int up, double *const shift[3],
                 const tl_effect_wanted *wanted) {
  double *const *mount = tl_columns_mount(p), *column;
  size_t i;
  int j;

  swing(p->segment, shape, mount[up], shift);
  for (j = 0; j < TL_MAX_JOINTS; j++) {
    if (!(column = tl_columns_of(p, wanted, j, up ? RISE : SWAY))) continue;
    for (i = 0; i < p->segment->n; i++)
      column[i] += shift[2][i] * (mount[4 + !up][i] + (j == 0 ? mount[2 + !up][i] : 0.0));
  }
}

static void columns(tl_effect_prepared *p, int joint, const double *shape, const tl_effect_wanted *wanted) {
  size_t n = p->segment->n;
  double *const shift[3] = {p->work, p->work + n, p->work + 2 * n};
  int up;

  (void)joint;
  if (tl_columns_wants(wanted, 1u << TURN)) turn(p, shape, shift, wanted);
  for (up = 0; up < 2; up++)
    if (tl_columns_wants(wanted, 1u << (up ? RISE : SWAY))) move(p, shape, up, shift, wanted);
}

const tl_effect_kind tl_effect_base_compliance = {
    .name = "base_compliance",
    .order = 220,
    .meaning = "the mount turns, sways or rises on its own spring",
    .places = TL_EFFECT_AT_BASE,
    .acts = TL_EFFECT_CHANGE,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter = {[TURN] = {"compliance_rad_Nm", 0.0, 0.05, 0.001, 0, 0.0},
                  [SWAY] = {"sway_m_N", 0.0, 0.05, 0.0, TL_DEFAULT(0.0)},
                  [RISE] = {"rise_m_N", 0.0, 0.05, 0.0, TL_DEFAULT(0.0)},
                  [STRENGTHS + FREQUENCY] = {"frequency_Hz", 1.0, 40.0, 8.0, 0, 0.0},
                  [STRENGTHS + DAMPING] = {"damping_ratio", 0.005, 1.0, 0.05, 0, 0.0}},
    .change = change,
    .columns = columns,
    .memory_s = 1.5,
};
