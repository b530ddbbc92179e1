/* plant.c: one interface over leg, pendulum and slider, see talus/plant.h. */
#include "talus/plant.h"

#include "plant_internal.h"

static double sign_of(double x) {
  return (double)((x > 0.0) - (x < 0.0));
}

void tl_slip_from_velocity(const tl_model *m, tl_motion *motion) {
  double ankle_speed = motion->v[1];

  if (m->plant == TL_PLANT_LEG && m->form == TL_FORM_PAPER) ankle_speed += motion->v[0];
  motion->slip[0] = sign_of(motion->v[0]);
  motion->slip[1] = sign_of(ankle_speed);
}

/* sign_of without a branch or a whole number, for loops in vector registers */
static void signs_of(const double *restrict x, const double *restrict plus, size_t n, double *restrict sign) {
  size_t i;

  for (i = 0; i < n; i++) {
    double sum = plus ? x[i] + plus[i] : x[i];
    sign[i] = sum > 0.0 ? 1.0 : sum < 0.0 ? -1.0 : 0.0;
  }
}

void tl_piece_slip(const tl_model *m, const double *const v[TL_MAX_JOINTS], size_t n,
                   double slip[TL_MAX_JOINTS][TL_PIECE]) {
  int paper = m->plant == TL_PLANT_LEG && m->form == TL_FORM_PAPER;

  signs_of(v[0], NULL, n, slip[0]);
  if (tl_joint_count(m) > 1) signs_of(v[1], paper ? v[0] : NULL, n, slip[1]);
}

void tl_inverse(const tl_model *m, const tl_motion *motion, double torque[TL_MAX_JOINTS]) {
  switch (m->plant) {
  case TL_PLANT_LEG: tl_leg_inverse(m, motion, torque); break;
  case TL_PLANT_PENDULUM: tl_pendulum_inverse(m, motion, torque); break;
  case TL_PLANT_SLIDER: tl_slider_inverse(m, motion, torque); break;
  }
}

void tl_inverse_batch(const tl_model *m, size_t n, const double *q, const double *v, const double *a,
                      const double *slip, double *torque) {
  tl_motion now = {{0.0}, {0.0}, {0.0}, {0.0}};
  double at_once[TL_MAX_JOINTS];
  int joints = tl_joint_count(m), j;
  size_t i;

  for (i = 0; i < n; i++) {
    for (j = 0; j < joints; j++) {
      size_t at = (size_t)j * n + i;

      now.q[j] = q[at];
      now.v[j] = v[at];
      now.a[j] = a[at];
      if (slip) now.slip[j] = slip[at];
    }
    if (!slip) tl_slip_from_velocity(m, &now);
    tl_inverse(m, &now, at_once);
    for (j = 0; j < joints; j++) torque[(size_t)j * n + i] = at_once[j];
  }
}

/* one degree of freedom: what torque is left after the rest, over the inertia */
static tl_status forward_one(const tl_model *m, const double torque[TL_MAX_JOINTS], tl_motion *motion) {
  double inertia = m->plant == TL_PLANT_SLIDER ? m->mass_kg : m->inertia_kg_m2, bias[TL_MAX_JOINTS];
  tl_motion at_rest = *motion;

  if (!(inertia > 0.0)) return TL_ERR_SINGULAR;
  at_rest.a[0] = 0.0;
  tl_inverse(m, &at_rest, bias);
  motion->a[0] = (torque[0] - bias[0]) / inertia;
  return TL_OK;
}

tl_status tl_forward(const tl_model *m, const double torque[TL_MAX_JOINTS], tl_motion *motion) {
  switch (m->plant) {
  case TL_PLANT_LEG: return tl_leg_forward(m, torque, motion);
  case TL_PLANT_PENDULUM:
  case TL_PLANT_SLIDER: return forward_one(m, torque, motion);
  }
  return TL_ERR_ARGUMENT;
}

void tl_inertia_matrix(const tl_model *m, const double q[TL_MAX_JOINTS],
                       double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS]) {
  switch (m->plant) {
  case TL_PLANT_LEG: tl_leg_inertia_matrix(m, q, matrix); break;
  case TL_PLANT_PENDULUM: matrix[0] = m->inertia_kg_m2; break;
  case TL_PLANT_SLIDER: matrix[0] = m->mass_kg; break;
  }
}

void tl_joint_torque(const tl_model *m, const double q[TL_MAX_JOINTS], const double torque[TL_MAX_JOINTS],
                     double joint_torque[TL_MAX_JOINTS]) {
  double ratio[TL_MAX_JOINTS] = {1.0, 1.0};
  int joints = tl_joint_count(m), j;

  if (m->plant == TL_PLANT_LEG) tl_leg_ratios(m, q, ratio);
  for (j = 0; j < TL_MAX_JOINTS && j < joints; j++) joint_torque[j] = ratio[j] * torque[j];
}

void tl_energy(const tl_model *m, const tl_motion *motion, double *kinetic_J, double *potential_J) {
  double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS] = {0.0}, twice = 0.0;
  int joints = tl_joint_count(m), i, j;

  tl_inertia_matrix(m, motion->q, matrix);
  for (i = 0; i < joints; i++)
    for (j = 0; j < joints; j++) twice += matrix[i * joints + j] * motion->v[i] * motion->v[j];
  *kinetic_J = 0.5 * twice;
  *potential_J = 0.0;
  if (m->plant == TL_PLANT_LEG) *potential_J = tl_leg_potential(m, motion->q);
  if (m->plant == TL_PLANT_PENDULUM) *potential_J = tl_pendulum_potential(m, motion->q);
}

void tl_regressor(const tl_model *m, const tl_motion *motion, double row[TL_MAX_JOINTS * TL_MAX_ROW],
                  double known[TL_MAX_JOINTS]) {
  int i;

  if (m->plant == TL_PLANT_LEG) {
    tl_leg_regressor(m, motion, row, known);
    return;
  }
  for (i = 0; i < TL_MAX_JOINTS * TL_MAX_ROW; i++) row[i] = 0.0;
  known[0] = known[1] = 0.0;
  if (m->plant == TL_PLANT_PENDULUM) tl_pendulum_regressor(m, motion, row);
  if (m->plant == TL_PLANT_SLIDER) tl_slider_regressor(motion, row);
}
