/* kinematic_error.c: a harmonic drive's error once, twice or four times a turn of its wave generator: a torque ripple at
 * the joint, and an angle by which the joint runs ahead of its motor (Tuttle and Seering 1996) */
#include "../effect_columns.h"

#include "talus/math.h"

enum { SINE, COSINE, SINE_ANGLE, COSINE_ANGLE, SINE_SHARE, COSINE_SHARE, STRENGTHS };
enum { PER_TURN, FADES, SHAPES };

static void law(const tl_effect_instant *now, const double *shape, double *torque, double *friction) {
  double shown = tl_effect_ripple_shown(now, shape[PER_TURN], shape[FADES]);
  int k;

  tl_sincos(shape[PER_TURN] * now->motor_rad, &torque[SINE], &torque[COSINE]);
  for (k = 0; k < 2; k++) { /* sine, cosine */
    torque[SINE + k] *= shown;
    torque[SINE_ANGLE + k] = 0.0;
    torque[SINE_SHARE + k] = now->load_Nm * torque[SINE + k];
  }
  for (k = 0; k < STRENGTHS; k++) friction[k] = 0.0;
}

static void change(const double *value, tl_effect_change *to) {
  tl_effect_add_wave(&to->ripple, value[STRENGTHS + PER_TURN], value[SINE_ANGLE], value[COSINE_ANGLE]);
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
    if (!tl_columns_wants(wanted, 1u << (SINE_ANGLE + k))) continue;
    tl_columns_wave(p, joint, shape[PER_TURN], k, shift);
    tl_columns_displaced(p, joint, shift, SINE_ANGLE + k, wanted);
    if ((column = tl_columns_of(p, wanted, joint, SINE_ANGLE + k)))
      add_slope(p, joint, shape[PER_TURN], k, shift[3], column);
  }
}

const tl_effect_kind tl_effect_kinematic_error = {
    .name = "kinematic_error",
    .order = 80,
    .meaning = "ripple of a harmonic drive's wave generator, in torque or in angle",
    .places = TL_EFFECT_AT_KNEE | TL_EFFECT_AT_SINGLE,
    .acts = TL_EFFECT_MECHANICAL,
    .needs_load_sensor = 0,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter = {[SINE] = {"sine_Nm", -100.0, 100.0, 0.2, 0, 0.0},
                  [COSINE] = {"cosine_Nm", -100.0, 100.0, 0.0, 0, 0.0},
                  [SINE_ANGLE] = {"sine_rad", -0.1, 0.1, 0.0, TL_DEFAULT(0.0)},
                  [COSINE_ANGLE] = {"cosine_rad", -0.1, 0.1, 0.0, TL_DEFAULT(0.0)},
                  [SINE_SHARE] = {"sine_share", -1.0, 1.0, 0.0, TL_DEFAULT(0.0)}, /* of the load */
                  [COSINE_SHARE] = {"cosine_share", -1.0, 1.0, 0.0, TL_DEFAULT(0.0)},
                  [STRENGTHS + PER_TURN] = {"per_turn", 0.01, 4.0, 2.0, 0, 0.0},
                  [STRENGTHS + FADES] = {"fades_Hz", 0.0, 1000.0, 0.0, TL_DEFAULT(0.0)}},
    .law = law,
    .change = change,
    .columns = columns,
};
