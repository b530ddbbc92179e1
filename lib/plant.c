/* plant.c: dynamics of any plant by its row of the table, see talus/plant.h. */
#include "talus/plant.h"

#include "math_inline.h"
#include "plant_internal.h"

static double sign_of(double x) {
  return (double)((x > 0.0) - (x < 0.0));
}

void tl_slip_from_velocity(const tl_model *m, tl_motion *motion) {
  double ankle_speed = motion->v[1];

  if (m->form == TL_FORM_PAPER) ankle_speed += motion->v[0];
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

void tl_slip_block(const tl_model *m, const double *const v[TL_MAX_JOINTS], size_t n,
                   double slip[TL_MAX_JOINTS][TL_BLOCK_ROWS]) {
  int paper = m->form == TL_FORM_PAPER;

  signs_of(v[0], NULL, n, slip[0]);
  if (tl_joint_count(m) > 1) signs_of(v[1], paper ? v[0] : NULL, n, slip[1]);
}

void tl_inverse(const tl_model *m, const tl_motion *motion, double torque[TL_MAX_JOINTS]) {
  tl_plant_table_of(m->plant)->inverse(m, motion, torque);
}

void tl_inverse_batch(const tl_model *m, size_t n, const double *q, const double *v, const double *a,
                      const double *slip, double *torque) {
  const tl_plant_table *t = tl_plant_table_of(m->plant);
  tl_motion now = {{0.0}, {0.0}, {0.0}, {0.0}};
  double at_once[TL_MAX_JOINTS] = {0.0, 0.0};
  int joints = t->facts.joints < TL_MAX_JOINTS ? t->facts.joints : TL_MAX_JOINTS, j;
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
    t->inverse(m, &now, at_once);
    for (j = 0; j < joints; j++) torque[(size_t)j * n + i] = at_once[j];
  }
}

/* one degree of freedom: what torque is left after the rest, over the inertia */
static tl_status forward_one(const tl_model *m, const double torque[TL_MAX_JOINTS], tl_motion *motion) {
  double inertia[TL_MAX_JOINTS * TL_MAX_JOINTS] = {0.0}, bias[TL_MAX_JOINTS] = {0.0, 0.0};
  tl_motion at_rest = *motion;

  tl_inertia_matrix(m, motion->q, inertia);
  if (!(inertia[0] > 0.0)) return TL_ERR_SINGULAR;
  at_rest.a[0] = 0.0;
  tl_inverse(m, &at_rest, bias);
  motion->a[0] = (torque[0] - bias[0]) / inertia[0];
  return TL_OK;
}

tl_status tl_forward(const tl_model *m, const double torque[TL_MAX_JOINTS], tl_motion *motion) {
  const tl_plant_table *t = tl_plant_table_of(m->plant);

  if (t->forward) return t->forward(m, torque, motion);
  return t->facts.joints == 1 ? forward_one(m, torque, motion) : TL_ERR_ARGUMENT;
}

void tl_inertia_matrix(const tl_model *m, const double q[TL_MAX_JOINTS],
                       double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS]) {
  const tl_plant_table *t = tl_plant_table_of(m->plant);

  if (t->inertia_matrix) t->inertia_matrix(m, q, matrix);
}

void tl_joint_torque(const tl_model *m, const double q[TL_MAX_JOINTS], const double torque[TL_MAX_JOINTS],
                     double joint_torque[TL_MAX_JOINTS]) {
  const tl_plant_table *t = tl_plant_table_of(m->plant);
  double ratio[TL_MAX_JOINTS] = {1.0, 1.0};
  int j;

  if (t->ratios) t->ratios(m, q, ratio);
  for (j = 0; j < TL_MAX_JOINTS && j < t->facts.joints; j++) joint_torque[j] = ratio[j] * torque[j];
}

void tl_energy(const tl_model *m, const tl_motion *motion, double *kinetic_J, double *potential_J) {
  const tl_plant_table *t = tl_plant_table_of(m->plant);
  double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS] = {0.0}, twice = 0.0;
  int joints = t->facts.joints, i, j;

  tl_inertia_matrix(m, motion->q, matrix);
  for (i = 0; i < joints; i++)
    for (j = 0; j < joints; j++) twice += matrix[tl_entry(joints, i, j)] * motion->v[i] * motion->v[j];
  *kinetic_J = 0.5 * twice;
  *potential_J = t->potential ? t->potential(m, motion->q) : 0.0;
}

void tl_tilt_by_turning(const tl_model *m, const double q[TL_MAX_JOINTS],
                        double joint_torque[TL_MAX_JOINTS]) {
  static const double quarter = 1.5707963267948966;
  double torque[TL_MAX_JOINTS] = {0.0, 0.0};
  tl_model still = *m;
  tl_motion turned = {{0.0}, {0.0}, {0.0}, {0.0}};
  int j;

  /* g sin(q + pi/2) = g cos q is what sin q changes by per rad */
  for (j = 0; j < TL_MAX_JOINTS; j++) {
    turned.q[j] = q[j];
    still.drive[j].coulomb_Nm = still.drive[j].viscous_Nms_rad = 0.0;
    if (tl_transmission_fixed(&still.drive[j].transmission, 1.0) != TL_OK) return;
  }
  tl_clear_offsets(&still);
  turned.q[0] += quarter;
  tl_inverse(&still, &turned, torque);
  tl_joint_torque(&still, turned.q, torque, joint_torque);
}

void tl_gravity_tilt(const tl_model *m, const double q[TL_MAX_JOINTS], double joint_torque[TL_MAX_JOINTS]) {
  const tl_plant_table *t = tl_plant_table_of(m->plant);
  int j;

  for (j = 0; j < t->facts.joints; j++) joint_torque[j] = 0.0;
  if (t->tilt) t->tilt(m, q, joint_torque);
}

void tl_regressor(const tl_model *m, const tl_motion *motion, double row[TL_MAX_JOINTS * TL_MAX_ROW],
                  double known[TL_MAX_JOINTS]) {
  const tl_plant_table *t = tl_plant_table_of(m->plant);
  int i;

  for (i = 0; i < TL_MAX_JOINTS * TL_MAX_ROW; i++) row[i] = 0.0;
  for (i = 0; i < TL_MAX_JOINTS; i++) known[i] = 0.0;
  if (t->regressor) t->regressor(m, motion, row, known);
}

/* rows of any plant, one instant after the other */
static void put_rows(const tl_model *m, const tl_motion_block *motion, size_t n, tl_regressor_block *rows) {
  double row[TL_MAX_JOINTS * TL_MAX_ROW], known[TL_MAX_JOINTS];
  int joints = tl_joint_count(m), j, c;
  size_t i;

  for (i = 0; i < n; i++) {
    tl_motion now = {{0.0}, {0.0}, {0.0}, {0.0}};
    for (j = 0; j < joints; j++) {
      now.q[j] = motion->q[j][i];
      now.v[j] = motion->v[j][i];
      now.a[j] = motion->a[j][i];
      now.slip[j] = motion->slip[j][i];
    }
    tl_regressor(m, &now, row, known);
    for (j = 0; j < joints; j++) {
      for (c = 0; c < TL_MAX_ROW; c++) rows->column[j][c][i] = row[j * TL_MAX_ROW + c];
      rows->known[j][i] = known[j];
    }
  }
}

void tl_regressor_rows(const tl_model *m, const tl_motion_block *motion, size_t n, tl_regressor_block *rows) {
  const tl_plant_table *t = tl_plant_table_of(m->plant);

  if (t->rows)
    t->rows(m, motion, n, rows);
  else
    put_rows(m, motion, n, rows);
}
