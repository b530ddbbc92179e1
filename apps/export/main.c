/* talus-export: an identified model as what something else reads; --to c: a header for a controller. Simulators' files are
 * written by talus-export-simulator, which is Python: it gets the command line as it is. */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "common/cli.h"
#include "common/output.h"
#include "controller/controller_options.h"
#include "header.h"
#include "model/model_file.h"

static struct { const char *to, *out, *name; } asked = {.to = "c"};
static struct controller_options drives = CONTROLLER_DEFAULTS;

static const struct cli_option options[] = {
    {"to", 't', CLI_TEXT, &asked.to, 1, "c",
     "c, a header for the controller; mjcf, urdf, sdf, bam, isaac or mcap"},
    {"out", 'o', CLI_TEXT, &asked.out, 1, "OUT", "where to write"},
    {"name", 'n', CLI_TEXT, &asked.name, 0, "NAME", "how the header's constants begin (default: from --out)"},
    {"tick", 0, CLI_NUMBER, &drives.tick_s, 0, "S", "the control loop's period (default 0.001)"},
    CONTROLLER_OPTIONS(drives),
};

static const struct cli_program program = {
    .name = "talus-export",
    .summary = "writes an identified model for a controller",
    .example = "talus-export --to c --out leg.h fitted.yaml\n"
               "talus-export --to mjcf --out leg.xml fitted.yaml",
    .arguments = "FITTED.yaml",
    .min_arguments = 1,
    .max_arguments = 1,
    .option = options,
    .options = sizeof options / sizeof options[0],
    .more =
        "--to c: a header with the constants of tl_controller_f64, _f32 and _q31 and their tables. It needs\n"
        "talus/controller.h and the sources controller_*.c, curve_*.c and fixed.c, and nothing else. An "
        "effect\n"
        "of the model that has no fast form is named and nothing is written.\n"
        "The other targets have options of their own: talus-export --to mjcf --help.",
};

static const char *const elsewhere[] = {"mjcf", "urdf", "sdf", "bam", "isaac", "mcap"};

/* What --to asks for, before the command line is read: other targets have other options. NULL without it. */
static const char *target_of(int argc, char **argv) {
  int i;

  for (i = 1; i < argc && strcmp(argv[i], "--") != 0; i++) {
    if (strncmp(argv[i], "--to=", 5) == 0) return argv[i] + 5;
    if (strcmp(argv[i], "--to") == 0 || strcmp(argv[i], "-t") == 0) return argv[i + 1];
    if (strncmp(argv[i], "-t", 2) == 0) return argv[i] + 2;
  }
  return NULL;
}

/* The program beside this one, with the same arguments; returns where it cannot be started. */
static int hand_over(char **argv) {
  const char *slash = strrchr(argv[0], '/');
  char path[4096];
  int n = snprintf(path, sizeof path, "%.*stalus-export-simulator", slash ? (int)(slash + 1 - argv[0]) : 0,
                   argv[0]);

  if (n > 0 && (size_t)n < sizeof path) (void)execvp(path, argv);
  (void)cli_complain("talus-export-simulator, which writes it, cannot be started");
  return APP_FAILED;
}

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
  const char *to = target_of(argc, argv);
  size_t i;
  int first;

  for (i = 0; to && i < sizeof elsewhere / sizeof elsewhere[0]; i++)
    if (strcmp(to, elsewhere[i]) == 0) return hand_over(argv);
  switch (cli_parse(&program, argc, argv, &first)) {
  case CLI_RUN: break;
  case CLI_DONE: return APP_OK;
  case CLI_USAGE: return APP_BAD_INPUT;
  }
  if (strcmp(asked.to, "c") != 0) {
    (void)cli_complain("--to: expected c, mjcf, urdf, sdf, bam, isaac or mcap, got %s", asked.to);
    return APP_BAD_INPUT;
  }
  if (output_same(asked.out, argv[first])) {
    (void)cli_complain("--out: %s is the model, it would be lost", asked.out);
    return APP_BAD_INPUT;
  }
  return write_header(argv[first], &error) == 0 ? APP_OK : app_exit(&error);
}
