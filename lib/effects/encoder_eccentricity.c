/* encoder_eccentricity.c: encoders mounted off the axis: an error once a turn, or some whole times */
#include "../effect_columns.h"

#include "talus/math.h"

static void change(const double *value, tl_effect_change *to) {
  to->motor_sine_rad += value[0];
  to->motor_cosine_rad += value[1];
  to->joint_sine_rad += value[2];
  to->joint_cosine_rad += value[3];
}

static void along(const tl_effect_stretch *s, int joint, const double *shape, int shows, double *column) {
  double *shift[4] = {s->work, s->work + s->n, s->work + 2 * s->n, s->work + 3 * s->n}, one[2];
  int k, d;
  size_t i;

  for (k = 0; k < 2; k++) {
    tl_columns_wave(s, joint, shape[0], k, shift);
    /* The motor's encoder shows so much too much, so the joint stands that over the ratio behind what it shows.
     * The ratio changes slowly beside the error: its own rates are left out. */
    for (i = 0; i < s->n; i++)
      for (d = 0; d < 3; d++) shift[d][i] /= -shift[3][i];
    tl_columns_displaced(s, s->model, joint, shift, shows, column + (size_t)k * s->n);
  }
  tl_columns_nothing(column + 2 * s->n, 2 * s->n);
  for (i = 0; i < s->n && shows == TL_EFFECT_SHOWS_ENCODER; i++) {
    tl_sincos(shape[1] * s->q[joint][i], &one[0], &one[1]);
    for (k = 0; k < 2; k++) column[(size_t)(2 + k) * s->n + i] = one[k];
  }
}

const tl_effect_kind tl_effect_encoder_eccentricity = {
    .name = "encoder_eccentricity",
    .order = 170,
    .meaning = "an encoder's error once a turn of the motor, or of the joint",
    .places = TL_EFFECT_AT_ANKLE,
    .acts = TL_EFFECT_CHANGE,
    .strengths = 4,
    .shapes = 2,
    .parameter = {{"motor_sine_rad", -3.0, 3.0, 0.004, 0, 0.0},
                  {"motor_cosine_rad", -3.0, 3.0, 0.0, 0, 0.0},
                  {"joint_sine_rad", -0.1, 0.1, 0.004, 0, 0.0},
                  {"joint_cosine_rad", -0.1, 0.1, 0.0, 0, 0.0},
                  {"motor_per_turn", 1.0, 100.0, 1.0, TL_FIT_ONLY(1.0)},
                  {"joint_per_turn", 1.0, 1000.0, 1.0, TL_FIT_ONLY(1.0)}},
    .change = change,
    .along = along,
};
