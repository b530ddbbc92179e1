/* talus-export: an identified model as what something else reads; --to c: a header for a controller. */
#include <string.h>

#include "common/cli.h"
#include "common/output.h"
#include "header.h"
#include "model/model_file.h"

static struct {
  const char *to, *out, *name;
  double tick_s, current_A[2], power_W[2], low_rad[2], high_rad[2], fade_rad, friction_share;
} asked = {.to = "c",
           .tick_s = 1e-3,
           .current_A = {20.0, 20.0},
           .power_W = {200.0, 200.0},
           .low_rad = {-2.0, -TL_JOINT_RANGE_RAD},
           .high_rad = {2.0, TL_JOINT_RANGE_RAD},
           .fade_rad = 0.05,
           .friction_share = 0.9};

static const struct cli_option options[] = {
    {"to", 't', CLI_TEXT, &asked.to, 1, "c", "the kind of output: c, a header for the controller"},
    {"out", 'o', CLI_TEXT, &asked.out, 1, "OUT", "where to write"},
    {"name", 'n', CLI_TEXT, &asked.name, 0, "NAME", "how the header's constants begin (default: from --out)"},
    {"tick", 0, CLI_NUMBER, &asked.tick_s, 0, "S", "the control loop's period (default 0.001)"},
    {"knee-current", 0, CLI_NUMBER, &asked.current_A[0], 0, "A",
     "peak current of the knee's drive (default 20)"},
    {"ankle-current", 0, CLI_NUMBER, &asked.current_A[1], 0, "A", "of the ankle's (default 20)"},
    {"knee-power", 0, CLI_NUMBER, &asked.power_W[0], 0, "W",
     "peak mechanical power of the knee's motor (default 200)"},
    {"ankle-power", 0, CLI_NUMBER, &asked.power_W[1], 0, "W", "of the ankle's (default 200)"},
    {"knee-low", 0, CLI_NUMBER, &asked.low_rad[0], 0, "RAD", "the knee's lower stop (default -2)"},
    {"knee-high", 0, CLI_NUMBER, &asked.high_rad[0], 0, "RAD", "its upper stop (default 2)"},
    {"ankle-low", 0, CLI_NUMBER, &asked.low_rad[1], 0, "RAD", "the ankle's lower stop (default -0.5236)"},
    {"ankle-high", 0, CLI_NUMBER, &asked.high_rad[1], 0, "RAD", "its upper stop (default 0.5236)"},
    {"fade", 0, CLI_NUMBER, &asked.fade_rad, 0, "RAD",
     "torque towards a stop fades over this way (default 0.05)"},
    {"friction-share", 0, CLI_NUMBER, &asked.friction_share, 0, "X",
     "of the model's friction that is compensated (default 0.9)"},
};

static const struct cli_program program = {
    .name = "talus-export",
    .summary = "writes an identified model for a controller",
    .arguments = "FITTED.yaml",
    .min_arguments = 1,
    .max_arguments = 1,
    .option = options,
    .options = sizeof options / sizeof options[0],
    .more =
        "--to c: a header with the constants of tl_controller_f64, _f32 and _q31 and their tables. It needs\n"
        "talus/controller.h and the sources controller_*.c, curve_*.c and fixed.c, and nothing else. An "
        "effect\n"
        "of the model that has no fast form is named and nothing is written.",
};

static void settings_of(const tl_model *model, tl_controller_settings *s) {
  int j;

  tl_controller_defaults(model, s);
  s->tick_s = asked.tick_s;
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    tl_controller_joint_settings *to = &s->joint[j];

    to->current_limit_A = asked.current_A[j];
    to->torque_limit_Nm = asked.current_A[j] * model->drive[j].torque_constant_Nm_A;
    to->power_limit_W = asked.power_W[j];
    to->low_rad = asked.low_rad[j];
    to->high_rad = asked.high_rad[j];
    to->fade_rad = asked.fade_rad;
    to->friction_share = asked.friction_share;
    to->rate_Nm_s = 1.25 * tl_controller_least_rate(s, model, j);
  }
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
  if (tl_joint_count(&file->model) != TL_CONTROLLER_JOINTS || file->model.form != TL_FORM_LAGRANGE)
    return app_fail(error, APP_BAD_INPUT, "%s: expected plant: leg in form: lagrange", path);
  return app_fail(error, APP_BAD_INPUT, "%s: a limit or a number of the model: %s", path,
                  tl_status_text(status));
}

static int write_header(const char *path, struct app_error *error) {
  static struct model_file file;
  static struct header_parts parts;
  struct output *out;
  tl_status status;
  int refused;

  if (model_file_read(path, &file, error) != 0) return -1;
  settings_of(&file.model, &parts.settings);
  parts.model = &file.model;
  parts.path = path;
  status = tl_controller_prepare(&parts.f64, &file.model, file.effect, file.effects, &parts.settings,
                                 parts.knot_f64, &refused);
  if (status != TL_OK) return refuse(&file, path, status, refused, error);
  if (tl_controller_error_bound(&parts.f64, &file.model, file.effect, file.effects, &parts.settings,
                                &parts.bound) != TL_OK)
    return app_fail(error, APP_FAILED, "%s: no bound", path);
  if (header_name(asked.name ? asked.name : asked.out, parts.name, sizeof parts.name) != 0)
    return app_fail(error, APP_BAD_INPUT, "--name: expected letters, digits and _, at most %d",
                    HEADER_NAME_MAX);
  out = output_open(asked.out, error);
  if (!out) return -1;
  header_write(out, &parts);
  return output_commit(out, error);
}

int main(int argc, char **argv) {
  struct app_error error;
  int first;

  switch (cli_parse(&program, argc, argv, &first)) {
  case CLI_RUN: break;
  case CLI_DONE: return APP_OK;
  case CLI_USAGE: return APP_BAD_INPUT;
  }
  if (strcmp(asked.to, "c") != 0) {
    (void)cli_complain("--to: expected c, got %s", asked.to);
    return APP_BAD_INPUT;
  }
  if (output_same(asked.out, argv[first])) {
    (void)cli_complain("--out: %s is the model, it would be lost", asked.out);
    return APP_BAD_INPUT;
  }
  return write_header(argv[first], &error) == 0 ? APP_OK : app_exit(&error);
}
