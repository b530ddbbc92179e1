/* controller_pair.h: one controller in its three scalars, and motion brought to each; for the tests. */
#ifndef CONTROLLER_PAIR_H
#define CONTROLLER_PAIR_H

#include "model/model_file.h"
#include "talus/experimental/controller_prepare.h"

struct trio {
  struct model_file file;
  tl_controller_settings settings;
  tl_controller_f64 f64;
  tl_controller_f32 f32;
  tl_controller_q31 q31;
  tl_curve_knot_f64 knot_f64[TL_CONTROLLER_KNOTS];
  tl_curve_knot_f32 knot_f32[TL_CONTROLLER_KNOTS];
  tl_curve_knot_q31 knot_q31[TL_CONTROLLER_KNOTS];
};

/* friction_share 1, this peak current, and 1.25 times the least rate */
static inline int trio_read(struct trio *t, const char *path, double current_A, struct app_error *error) {
  int j, refused;

  if (model_file_read(path, &t->file, error) != 0) return -1;
  tl_controller_defaults(&t->file.model, &t->settings);
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    t->settings.joint[j].friction_share = 1.0;
    t->settings.joint[j].current_limit_A = current_A;
    t->settings.joint[j].rate_Nm_s = 1.25 * tl_controller_least_rate(&t->settings, &t->file.model, j);
  }
  if (tl_controller_prepare(&t->f64, &t->file.model, t->file.effect, t->file.effects, &t->settings,
                            t->knot_f64, &refused) != TL_OK)
    return app_fail(error, APP_BAD_INPUT, "not prepared: effect %d", refused);
  tl_controller_to_f32(&t->f64, t->knot_f32, &t->f32);
  if (tl_controller_to_q31(&t->f64, t->knot_q31, &t->q31) != TL_OK)
    return app_fail(error, APP_BAD_INPUT, "no fixed point");
  return 0;
}

/* the nearest frames that each scalar has; what is no number becomes the least whole number */
static inline void frame_to_f32(const tl_controller_frame_f64 *from, tl_controller_frame_f32 *to) {
  int j;

  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    to->angle_rad[j] = (float)from->angle_rad[j];
    to->speed_rad_s[j] = (float)from->speed_rad_s[j];
    to->acceleration[j] = (float)from->acceleration[j];
  }
  to->count = from->count;
}

static inline int32_t whole(double x, int q) {
  uint32_t saturated = 0;

  return x != x ? INT32_MIN : tl_fixed_from_double(x, q, &saturated);
}

static inline void frame_to_q31(const tl_controller_frame_f64 *from, tl_controller_frame_q31 *to) {
  int j;

  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    to->angle_rad[j] = whole(from->angle_rad[j], TL_Q_ANGLE);
    to->speed_rad_s[j] = whole(from->speed_rad_s[j], TL_Q_SPEED);
    to->acceleration[j] = whole(from->acceleration[j], TL_Q_ACCELERATION);
  }
  to->count = from->count;
}

#endif
