/* kinematic_error.c: a harmonic drive's error once, twice or four times a turn of its wave generator: a torque ripple at
 * the joint, and an angle by which the joint runs ahead of its motor (Tuttle and Seering 1996) */
#include "../effect_columns.h"

#include "talus/math.h"

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double shown = tl_effect_ripple_shown(now, shape[0], shape[1]);
  int k;

  tl_sincos(shape[0] * now->motor_rad, &torque[0], &torque[1]);
  for (k = 0; k < 2; k++) {
    torque[k] *= shown;
    torque[2 + k] = 0.0;
    torque[4 + k] = now->load_Nm * torque[k];
  }
  for (k = 0; k < 6; k++) friction[k] = 0.0;
}

/* by virtual work the motor feels the load by the slope of the angle that runs ahead, too */
static void add_slope(const tl_effect_stretch *s, const tl_model *link, int joint, double order, int k,
                      double *const shift[4], double *column) {
  const tl_transmission *t = &s->model->drive[joint].transmission;
  double *load = shift[1], wave[2];
  size_t i;

  tl_columns_load(s, link, joint, load);
  for (i = 0; i < s->n; i++) {
    tl_sincos(order * tl_transmission_motor_angle(t, s->q[joint][i]), &wave[0], &wave[1]);
    column[i] += load[i] * (k == 0 ? wave[1] : -wave[0]) * order * shift[3][i];
  }
}

static void along(const tl_effect_stretch *s, int joint, const double *shape, int shows, double *column) {
  double *shift[4] = {s->work, s->work + s->n, s->work + 2 * s->n, s->work + 3 * s->n};
  tl_model link = tl_effect_bare_model(s->model);
  int k;

  tl_columns_nothing(column, 2 * s->n);
  tl_columns_nothing(column + 4 * s->n, 2 * s->n);
  for (k = 0; k < 2; k++) {
    tl_columns_wave(s, joint, shape[0], k, shift);
    tl_columns_displaced(s, &link, joint, shift, shows, column + (size_t)(2 + k) * s->n);
    if (shows == joint) add_slope(s, &link, joint, shape[0], k, shift, column + (size_t)(2 + k) * s->n);
  }
}

const tl_effect_kind tl_effect_kinematic_error = {
    .name = "kinematic_error",
    .order = 80,
    .meaning = "ripple of a harmonic drive's wave generator, in torque or in angle",
    .places = TL_EFFECT_AT_KNEE | TL_EFFECT_AT_SINGLE,
    .acts = TL_EFFECT_MECHANICAL,
    .needs_load_sensor = 0,
    .strengths = 6,
    .shapes = 2,
    .parameter = {{"sine_Nm", -100.0, 100.0, 0.2, 0, 0.0},
                  {"cosine_Nm", -100.0, 100.0, 0.0, 0, 0.0},
                  {"sine_rad", -0.1, 0.1, 0.0, TL_FIT_ONLY(0.0)},
                  {"cosine_rad", -0.1, 0.1, 0.0, TL_FIT_ONLY(0.0)},
                  {"sine_share", -1.0, 1.0, 0.0, TL_FIT_ONLY(0.0)}, /* of the load */
                  {"cosine_share", -1.0, 1.0, 0.0, TL_FIT_ONLY(0.0)},
                  {"per_turn", 0.01, 4.0, 2.0, 0, 0.0},
                  {"fades_Hz", 0.0, 1000.0, 0.0, TL_FIT_ONLY(0.0)}},
    .law = law,
    .along = along,
};
