/* linkage_error.c: a screw linkage built with other dimensions than the drawing's */
#include "../effect_columns.h"

#include <string.h>

enum { AB, BO, AC, BOF, STRENGTHS };

#define STEP_M 1e-5 /* and rad */

static void change(const double *value, tl_effect_change *to) {
  to->AB_m += value[AB];
  to->BO_m += value[BO];
  to->AC_m += value[AC];
  to->BOF_rad += value[BOF];
}

/* the motor's motion at row i, as the model's linkage gave the joint's from it */
static void motor_motion(const tl_effect_segment *s, int joint, size_t i, double motor[3]) {
  const tl_transmission *t = &s->model->drive[joint].transmission;
  double slope, ratio, v = s->v[joint][i];

  tl_transmission_ratio(t, s->q[joint][i], &ratio, &slope);
  motor[0] = tl_transmission_motor_angle(t, s->q[joint][i]);
  motor[1] = ratio * v;
  motor[2] = ratio * s->a[joint][i] + slope * v * v;
}

/* what `other` (a model with another linkage) shows at every row, times weight, into the columns of strength k */
static void add_shown(const tl_effect_prepared *p, int joint, const tl_model *other, double weight, int k,
                      const tl_effect_wanted *wanted) {
  const tl_effect_segment *s = p->segment;
  double motor[3], moved[3], torque[TL_MAX_JOINTS], *column;
  tl_motion now, moved_now;
  size_t i;
  int c;

  for (i = 0; i < s->n; i++) {
    motor_motion(s, joint, i, motor);
    tl_transmission_joint_motion(&other->drive[joint].transmission, motor, moved);
    tl_columns_motion(s, i, &now);
    moved_now = now;
    moved_now.q[joint] = moved[0];
    moved_now.v[joint] = moved[1];
    moved_now.a[joint] = moved[2];
    tl_inverse(other, &moved_now, torque);
    tl_joint_torque(s->model, now.q, torque, torque);
    for (c = 0; c < TL_EFFECT_CHANNELS; c++)
      if (c < TL_MAX_JOINTS || tl_columns_sees(joint, c))
        if ((column = tl_columns_of(p, wanted, c, k)))
          column[i] += weight * (c < TL_MAX_JOINTS ? torque[c] : moved[0]);
  }
}

static void columns(tl_effect_prepared *p, int joint, const double *shape, const tl_effect_wanted *wanted) {
  static const double sign[2] = {1.0, -1.0};
  const tl_transmission *t = &p->segment->model->drive[joint].transmission;
  tl_model other = *p->segment->model;
  int k, side;

  (void)shape;
  for (k = 0; k < STRENGTHS && t->kind == TL_TRANSMISSION_SCREW_LINKAGE; k++)
    for (side = 0; side < 2 && tl_columns_wants(wanted, 1u << k); side++) {
      tl_effect_change c;
      double *const dimension[STRENGTHS] = {
          [AB] = &c.AB_m, [BO] = &c.BO_m, [AC] = &c.AC_m, [BOF] = &c.BOF_rad};
      memset(&c, 0, sizeof c);
      *dimension[k] = sign[side] * STEP_M;
      if (tl_effect_change_linkage(&c, t, &other.drive[joint].transmission) != TL_OK) break;
      add_shown(p, joint, &other, sign[side] * 0.5 / STEP_M, k, wanted);
    }
}

const tl_effect_kind tl_effect_linkage_error = {
    .name = "linkage_error",
    .order = 180,
    .meaning = "the linkage's true dimensions differ from the model's",
    .places = TL_EFFECT_AT_ANKLE,
    .acts = TL_EFFECT_CHANGE,
    .strengths = STRENGTHS,
    .shapes = 0,
    .parameter = {[AB] = {"AB_m", -0.01, 0.01, 0.0, 0, 0.0},
                  [BO] = {"BO_m", -0.01, 0.01, 0.0015, 0, 0.0},
                  [AC] = {"AC_m", -0.01, 0.01, 0.0, 0, 0.0},
                  [BOF] = {"BOF_rad", -0.2, 0.2, 0.0, TL_DEFAULT(0.0)}},
    .change = change,
    .columns = columns,
    .exact = 1,
    .fast = TL_FAST_DRIVE,
};
