/* encoder_eccentricity.c: encoders mounted off the axis: an error once a turn */
#include "along.h"

#include "talus/math.h"

static void change(const double *value, tl_effect_change *to) {
  to->motor_sine_rad += value[0];
  to->motor_cosine_rad += value[1];
  to->joint_sine_rad += value[2];
  to->joint_cosine_rad += value[3];
}

/* The motor's encoder shows e(theta) too much, so the joint stands e / ratio behind what it shows: with
 * sine (k = 0) or cosine (k = 1) of the motor's angle, and the rates by the chain rule. */
static void motor_error(const tl_effect_stretch *s, int joint, int k, size_t i, double shift[3]) {
  double motor, ratio, slope, sine, cosine, e[3], v = s->v[joint][i], a = s->a[joint][i];
  const tl_transmission *t = &s->model->drive[joint].transmission;

  motor = tl_transmission_motor_angle(t, s->q[joint][i]);
  tl_transmission_ratio(t, s->q[joint][i], &ratio, &slope);
  tl_sincos(motor, &sine, &cosine);
  e[0] = k == 0 ? sine : cosine;
  e[1] = (k == 0 ? cosine : -sine) * ratio * v;
  e[2] = (k == 0 ? cosine : -sine) * (ratio * a + slope * v * v) - e[0] * ratio * v * ratio * v;
  /* the ratio changes slowly beside the error: its own rates are left out */
  for (k = 0; k < 3; k++) shift[k] = -e[k] / ratio;
}

static void along(const tl_effect_stretch *s, int joint, const double *shape, int shows, double *column) {
  double *shift[3] = {s->work, s->work + s->n, s->work + 2 * s->n}, one[3];
  int k, d;
  size_t i;

  (void)shape;
  for (k = 0; k < 4; k++) {
    double *to = column + (size_t)k * s->n;
    tl_along_nothing(to, s->n);
    for (i = 0; i < s->n && k < 2; i++) {
      motor_error(s, joint, k, i, one);
      for (d = 0; d < 3; d++) shift[d][i] = one[d];
      if (shows == TL_EFFECT_SHOWS_ENCODER || shows == TL_EFFECT_SHOWS_FOOT) to[i] = one[0];
    }
    if (k < 2 && shows < TL_MAX_JOINTS) tl_along_shift(s, s->model, joint, shift, shows, to);
    for (i = 0; i < s->n && k >= 2 && shows == TL_EFFECT_SHOWS_ENCODER; i++) {
      tl_sincos(s->q[joint][i], &one[0], &one[1]);
      to[i] = one[k - 2];
    }
  }
}

const tl_effect_kind tl_effect_encoder_eccentricity = {
    .name = "encoder_eccentricity",
    .meaning = "an encoder's error once a turn of the motor, or of the joint",
    .places = TL_EFFECT_AT_ANKLE,
    .acts = TL_EFFECT_CHANGE,
    .strengths = 4,
    .shapes = 0,
    .parameter = {{"motor_sine_rad", -0.1, 0.1, 0.004},
                  {"motor_cosine_rad", -0.1, 0.1, 0.0},
                  {"joint_sine_rad", -0.1, 0.1, 0.004},
                  {"joint_cosine_rad", -0.1, 0.1, 0.0}},
    .change = change,
    .along = along,
};
