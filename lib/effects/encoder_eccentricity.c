/* encoder_eccentricity.c: encoders mounted off the axis: an error once a turn, or some whole times */
#include "../effect_columns.h"

#include "talus/math.h"

enum { MOTOR_SINE, MOTOR_COSINE, JOINT_SINE, JOINT_COSINE, STRENGTHS };
enum { MOTOR_PER_TURN, JOINT_PER_TURN, SHAPES };

static void change(const double *value, tl_effect_change *to) {
  const double *shape = value + STRENGTHS;

  tl_effect_add_wave(&to->motor_encoder, shape[MOTOR_PER_TURN], value[MOTOR_SINE], value[MOTOR_COSINE]);
  tl_effect_add_wave(&to->joint_encoder, shape[JOINT_PER_TURN], value[JOINT_SINE], value[JOINT_COSINE]);
}

/* The motor's encoder shows so much too much, so the joint stands that over the ratio behind what it shows.
 * The ratio changes slowly beside the error: its own rates are left out. */
static void of_motor(tl_effect_prepared *p, int joint, double order, int k, const tl_effect_wanted *wanted) {
  size_t n = p->segment->n, i;
  double *shift[4] = {p->work, p->work + n, p->work + 2 * n, p->work + 3 * n};
  int d;

  tl_columns_wave(p, joint, order, k, shift);
  for (i = 0; i < n; i++)
    for (d = 0; d < 3; d++) shift[d][i] /= -shift[3][i];
  tl_columns_displaced_whole(p, joint, shift, MOTOR_SINE + k, wanted);
}

static void columns(tl_effect_prepared *p, int joint, const double *shape, const tl_effect_wanted *wanted) {
  const tl_effect_segment *s = p->segment;
  double *column[2], one[2]; /* sine, cosine */
  size_t i;
  int k;

  for (k = 0; k < 2; k++) {
    if (tl_columns_wants(wanted, 1u << (MOTOR_SINE + k)))
      of_motor(p, joint, shape[MOTOR_PER_TURN], k, wanted);
    column[k] = tl_columns_of(p, wanted, TL_EFFECT_SHOWS_ENCODER, JOINT_SINE + k);
  }
  for (i = 0; i < s->n && (column[0] || column[1]); i++) {
    tl_sincos(shape[JOINT_PER_TURN] * s->q[joint][i], &one[0], &one[1]);
    for (k = 0; k < 2; k++)
      if (column[k]) column[k][i] = one[k];
  }
}

const tl_effect_kind tl_effect_encoder_eccentricity = {
    .name = "encoder_eccentricity",
    .order = 170,
    .meaning = "an encoder's error once a turn of the motor, or of the joint",
    .places = TL_EFFECT_AT_ANKLE,
    .acts = TL_EFFECT_CHANGE,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter = {[MOTOR_SINE] = {"motor_sine_rad", -3.0, 3.0, 0.004, 0, 0.0},
                  [MOTOR_COSINE] = {"motor_cosine_rad", -3.0, 3.0, 0.0, 0, 0.0},
                  [JOINT_SINE] = {"joint_sine_rad", -0.1, 0.1, 0.004, 0, 0.0},
                  [JOINT_COSINE] = {"joint_cosine_rad", -0.1, 0.1, 0.0, 0, 0.0},
                  [STRENGTHS + MOTOR_PER_TURN] = {"motor_per_turn", 1.0, 100.0, 1.0, TL_DEFAULT(1.0)},
                  [STRENGTHS + JOINT_PER_TURN] = {"joint_per_turn", 1.0, 1000.0, 1.0, TL_DEFAULT(1.0)}},
    .change = change,
    .columns = columns,
};
