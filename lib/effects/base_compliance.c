/* base_compliance.c: a mount that sways under the knee's torque */
#include "along.h"

#include "talus/math.h"

static void change(const double *value, tl_effect_change *to) {
  to->base_compliance_rad_Nm += value[0];
  to->base_hz = value[1];
  to->base_share = value[2];
}

/* The knee's torque turns the mount back: x'' + 2 d w x' + w^2 x = -w^2 compliance load, w with the leg
 * hanging from it. The sway adds to every absolute angle, as if the knee had moved. */
static void along(const tl_effect_stretch *s, int joint, const double *shape, int shows, double *column) {
  double *shift[3] = {s->work, s->work + s->n, s->work + 2 * s->n}, w = 2.0 * TL_PI * shape[0];
  tl_along_spring spring = {1.0 / (w * w), 1.0, 2.0 * shape[1] / w, 0.0, 0.0};
  tl_model link = tl_effect_bare_model(s->model);
  double x = 0.0, v = 0.0, before = 0.0, load;
  size_t i;

  (void)joint;
  tl_along_load(s, &link, 0, shift[2]);
  for (i = 0; i < s->n; i++) {
    load = shift[2][i];
    if (i == 0) x = -load;
    if (i > 0) tl_along_swing(&spring, before, load, s->t_s[i] - s->t_s[i - 1], &x, &v);
    before = load;
    shift[0][i] = x;
    shift[1][i] = v;
    shift[2][i] = -w * w * (load + x + spring.damping * v);
  }
  tl_along_nothing(column, s->n);
  if (shows < TL_MAX_JOINTS) tl_along_shift(s, &link, 0, shift, shows, column);
  if (shows == TL_EFFECT_SHOWS_SHANK) tl_along_copy(column, shift[0], s->n);
}

const tl_effect_kind tl_effect_base_compliance = {
    .name = "base_compliance",
    .meaning = "the mount sways on its own spring",
    .places = TL_EFFECT_AT_BASE,
    .acts = TL_EFFECT_CHANGE,
    .strengths = 1,
    .shapes = 2,
    .parameter = {{"compliance_rad_Nm", 0.0, 0.05, 0.001},
                  {"frequency_Hz", 1.0, 40.0, 8.0},
                  {"damping_ratio", 0.005, 1.0, 0.05}},
    .change = change,
    .along = along,
    .memory_s = 1.5,
};
