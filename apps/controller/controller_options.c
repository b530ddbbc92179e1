/* controller_options.c: see controller_options.h. */
#include "controller_options.h"

static void settings_of(const tl_model *model, const struct controller_options *asked,
                        tl_controller_settings *s) {
  tl_controller_defaults(model, s);
  s->tick_s = asked->tick_s;
  for (int j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    tl_controller_joint_settings *to = &s->joint[j];

    to->current_limit_A = asked->current_A[j];
    to->torque_limit_Nm = asked->current_A[j] * model->drive[j].torque_constant_Nm_A;
    to->power_limit_W = asked->power_W[j];
    to->low_rad = asked->low_rad[j];
    to->high_rad = asked->high_rad[j];
    to->fade_rad = asked->fade_rad;
    to->friction_share = asked->friction_share;
    to->rate_Nm_s = 1.25 * tl_controller_least_rate(s, model, j);
  }
}

static int is_leg(const tl_model *m) {
  return tl_joint_count(m) == TL_CONTROLLER_JOINTS && m->form == TL_FORM_LAGRANGE;
}

static int refuse(const struct model_file *file, const char *path, tl_status status, int refused,
                  struct app_error *error) {
  if (refused >= 0)
    return app_fail(
        error, APP_BAD_INPUT, "%s: the effect %s at the %s %s", path, file->effect[refused].kind->name,
        model_effect_joint(&file->model, file->effect[refused].joint),
        status == TL_ERR_UNSUPPORTED ? "has no fast form for a controller: expected one of those that "
                                       "docs/controller.md lists"
                                     : "is out of range");
  if (!is_leg(&file->model))
    return app_fail(error, APP_BAD_INPUT, "%s: expected plant: leg in form: lagrange", path);
  return app_fail(error, APP_BAD_INPUT, "%s: a limit or a number of the model: %s", path,
                  tl_status_text(status));
}

int controller_make(const struct model_file *file, const char *path, const struct controller_options *asked,
                    struct controller *made, struct app_error *error) {
  tl_status status;
  int refused = -1;

  if (!is_leg(&file->model)) return refuse(file, path, TL_ERR_UNSUPPORTED, refused, error);
  settings_of(&file->model, asked, &made->settings);
  status = tl_controller_prepare(&made->f64, &file->model, file->effect, file->effects, &made->settings,
                                 made->knot, &refused);
  return status == TL_OK ? 0 : refuse(file, path, status, refused, error);
}
