/* base_compliance.c: a mount that turns under the knee's torque, or sways or rises under the leg's forces */
#include "../effect_columns.h"

#include <string.h>

#include "talus/math.h"

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

/* x'' + 2 d w x' + w^2 x = -w^2 drive: x in shift[0], its rates in the others */
static void swing(const tl_effect_segment *s, const double *shape, const double *drive,
                  double *const shift[3]) {
  double w = 2.0 * TL_PI * shape[FREQUENCY], x, v = 0.0;
  tl_columns_spring spring = {1.0 / (w * w), 1.0, 2.0 * shape[DAMPING] / w};
  tl_columns_swing mount = tl_columns_swing_of(spring);
  size_t i;

  x = -drive[0];
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
