/* linkage_error.c: a screw linkage built with other dimensions than the drawing's */
#include "../effect_columns.h"

#include <string.h>

#define STEP_M 1e-5 /* and rad */

static void change(const double *value, tl_effect_change *to) {
  to->AB_m += value[0];
  to->BO_m += value[1];
  to->AC_m += value[2];
  to->BOF_rad += value[3];
}

/* the motor's motion at row i, as the model's linkage gave the joint's from it */
static void motor_motion(const tl_effect_stretch *s, int joint, size_t i, double motor[3], double *ratio) {
  const tl_transmission *t = &s->model->drive[joint].transmission;
  double slope, v = s->v[joint][i];

  tl_transmission_ratio(t, s->q[joint][i], ratio, &slope);
  motor[0] = tl_transmission_motor_angle(t, s->q[joint][i]);
  motor[1] = *ratio * v;
  motor[2] = *ratio * s->a[joint][i] + slope * v * v;
}

/* column of what `other` (a model with another linkage) shows at every row, times weight */
static void add_shown(const tl_effect_stretch *s, int joint, const tl_model *other, int shows, double weight,
                      double *column) {
  double motor[3], moved[3], torque[TL_MAX_JOINTS], ratio, other_ratio, slope;
  tl_motion now;
  size_t i;

  for (i = 0; i < s->n; i++) {
    motor_motion(s, joint, i, motor, &ratio);
    tl_transmission_joint_motion(&other->drive[joint].transmission, motor, moved);
    if (shows >= TL_MAX_JOINTS) {
      column[i] += weight * moved[0];
      continue;
    }
    tl_columns_motion(s, i, &now);
    now.q[joint] = moved[0];
    now.v[joint] = moved[1];
    now.a[joint] = moved[2];
    tl_inverse(other, &now, torque);
    tl_transmission_ratio(&s->model->drive[shows].transmission, s->q[shows][i], &other_ratio, &slope);
    column[i] += weight * torque[shows] * other_ratio;
  }
}

static void along(const tl_effect_stretch *s, int joint, const double *shape, int shows, double *column) {
  static const double sign[2] = {1.0, -1.0};
  tl_model other = *s->model;
  int k, side;

  (void)shape;
  for (k = 0; k < 4; k++) {
    double *to = column + (size_t)k * s->n;
    tl_columns_nothing(to, s->n);
    if (s->model->drive[joint].transmission.kind != TL_TRANSMISSION_SCREW_LINKAGE) continue;
    if (shows == TL_EFFECT_SHOWS_SHANK) continue;
    for (side = 0; side < 2; side++) {
      tl_effect_change c;
      double *const dimension[4] = {&c.AB_m, &c.BO_m, &c.AC_m, &c.BOF_rad};
      memset(&c, 0, sizeof c);
      *dimension[k] = sign[side] * STEP_M;
      if (tl_effect_change_linkage(&c, &s->model->drive[joint].transmission,
                                   &other.drive[joint].transmission) != TL_OK)
        break;
      add_shown(s, joint, &other, shows, sign[side] * 0.5 / STEP_M, to);
    }
  }
}

const tl_effect_kind tl_effect_linkage_error = {
    .name = "linkage_error",
    .order = 180,
    .meaning = "the linkage's true dimensions differ from the model's",
    .places = TL_EFFECT_AT_ANKLE,
    .acts = TL_EFFECT_CHANGE,
    .strengths = 4,
    .shapes = 0,
    .parameter = {{"AB_m", -0.01, 0.01, 0.0, 0, 0.0},
                  {"BO_m", -0.01, 0.01, 0.0015, 0, 0.0},
                  {"AC_m", -0.01, 0.01, 0.0, 0, 0.0},
                  {"BOF_rad", -0.2, 0.2, 0.0, TL_DEFAULT(0.0)}},
    .change = change,
    .along = along,
    .exact = 1,
};
