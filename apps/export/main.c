/* talus-export: an identified model as what something else reads; --to c: a header for a controller. */
#include <string.h>

#include "common/cli.h"
#include "common/output.h"
#include "controller/controller_options.h"
#include "header.h"
#include "model/model_file.h"

static struct { const char *to, *out, *name; } asked = {.to = "c"};
static struct controller_options drives = CONTROLLER_DEFAULTS;

static const struct cli_option options[] = {
    {"to", 't', CLI_TEXT, &asked.to, 1, "c", "the kind of output: c, a header for the controller"},
    {"out", 'o', CLI_TEXT, &asked.out, 1, "OUT", "where to write"},
    {"name", 'n', CLI_TEXT, &asked.name, 0, "NAME", "how the header's constants begin (default: from --out)"},
    {"tick", 0, CLI_NUMBER, &drives.tick_s, 0, "S", "the control loop's period (default 0.001)"},
    CONTROLLER_OPTIONS(drives),
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

static int write_header(const char *path, struct app_error *error) {
  static struct model_file file;
  static struct header_parts parts;
  struct output *out;

  if (model_file_read(path, &file, error) != 0) return -1;
  parts.model = &file.model;
  parts.path = path;
  if (controller_make(&file, path, &drives, &parts.made, error) != 0) return -1;
  if (tl_controller_error_bound(&parts.made.f64, &file.model, file.effect, file.effects, &parts.made.settings,
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
