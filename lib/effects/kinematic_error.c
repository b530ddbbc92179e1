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

static void change(const double *value, tl_effect_change *to) {
  tl_effect_add_wave(&to->ripple, value[6], value[2], value[3]);
}

/* by virtual work the motor feels the load by the slope of the angle that runs ahead, too */
static void add_slope(tl_effect_prepared *p, int joint, double order, int k, const double *ratio,
                      double *column) {
  const tl_effect_segment *s = p->segment;
  const tl_transmission *t = &s->model->drive[joint].transmission;
  const double *load = tl_columns_load(p, joint);
  double wave[2];
  size_t i;

  for (i = 0; i < s->n; i++) {
    tl_sincos(order * tl_transmission_motor_angle(t, s->q[joint][i]), &wave[0], &wave[1]);
    column[i] += load[i] * (k == 0 ? wave[1] : -wave[0]) * order * ratio[i];
  }
}

static void columns(tl_effect_prepared *p, int joint, const double *shape, const tl_effect_wanted *wanted) {
  size_t n = p->segment->n;
  double *shift[4] = {p->work, p->work + n, p->work + 2 * n, p->work + 3 * n}, *column;
  int k;

  for (k = 0; k < 2; k++) {
    if (!tl_columns_wants(wanted, 4u << k)) continue;
    tl_columns_wave(p, joint, shape[0], k, shift);
    tl_columns_displaced(p, joint, shift, 2 + k, wanted);
    if ((column = tl_columns_of(p, wanted, joint, 2 + k))) add_slope(p, joint, shape[0], k, shift[3], column);
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
                  {"sine_rad", -0.1, 0.1, 0.0, TL_DEFAULT(0.0)},
                  {"cosine_rad", -0.1, 0.1, 0.0, TL_DEFAULT(0.0)},
                  {"sine_share", -1.0, 1.0, 0.0, TL_DEFAULT(0.0)}, /* of the load */
                  {"cosine_share", -1.0, 1.0, 0.0, TL_DEFAULT(0.0)},
                  {"per_turn", 0.01, 4.0, 2.0, 0, 0.0},
                  {"fades_Hz", 0.0, 1000.0, 0.0, TL_DEFAULT(0.0)}},
    .law = law,
    .change = change,
    .columns = columns,
};
