/* talus-identify: fits a model's parameters to recordings by the seeded swarm. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/cli.h"
#include "common/decimal.h"
#include "common/output.h"
#include "common/progress.h"
#include "report.h"

/* ---- the command line -------------------------------------------------------- */

static struct {
  const char *model, *out, *report, *html;
  const char *window, *weights, *loss, *form, *topology;
  uint64_t seed, threads, particles, iterations, restarts;
  int quiet;
} asked;

static const struct cli_option options[] = {
    {"model", 'm', CLI_TEXT, &asked.model, 1, "M.yaml", "the model to start from"},
    {"out", 'o', CLI_TEXT, &asked.out, 1, "FITTED.yaml", "the identified model"},
    {"report", 'r', CLI_TEXT, &asked.report, 0, "R.json", "every figure, for machines"},
    {"html", 0, CLI_TEXT, &asked.html, 0, "R.html", "measured against predicted torque, as a page"},
    CLI_SEED_OPTION(&asked.seed),
    {"window", 'w', CLI_TEXT, &asked.window, 0, "ORDER,S",
     "window of the angles' reconstruction, \"20,1\" is the paper's\n(default: from the data, printed)"},
    {"weights", 0, CLI_TEXT, &asked.weights, 0, "KIND",
     "residuals by each joint's \"noise\" (default) or \"equal\", (16)"},
    {"loss", 0, CLI_TEXT, &asked.loss, 0, "KIND", "\"square\" (default) or \"huber\": outliers count less"},
    {"particles", 0, CLI_WHOLE, &asked.particles, 0, "N", "of the swarm"},
    {"iterations", 0, CLI_WHOLE, &asked.iterations, 0, "N", "at most"},
    {"restarts", 0, CLI_WHOLE, &asked.restarts, 0, "N", "independent swarms, the best one counts"},
    {"swarm-form", 0, CLI_TEXT, &asked.form, 0, "KIND", "\"constriction\" (default) or \"inertia\""},
    {"topology", 0, CLI_TEXT, &asked.topology, 0, "KIND", "\"global\" or \"ring\""},
    {"threads", 0, CLI_WHOLE, &asked.threads, 0, "N",
     "at most, that compute rows and move the swarm; the answer is the same\n(default: as many as "
     "processors, "
     "one for the swarm)"},
    {"quiet", 'q', CLI_FLAG, &asked.quiet, 0, NULL, "say nothing but warnings"},
};

static const struct cli_program program = {
    .name = "talus-identify",
    .summary = "fits a model's parameters to recordings by a seeded particle swarm",
    .example =
        "talus-identify --model leg.yaml --out fitted.yaml run.csv\n"
        "talus-identify --model leg.yaml --out fitted.yaml --report r.json --html r.html run1.csv run2.csv",
    .arguments = "REC.csv...",
    .min_arguments = 1,
    .max_arguments = CLI_ANY,
    .option = options,
    .options = sizeof options / sizeof options[0],
    .more = "The same seed, recordings and version give the same bytes in FITTED.yaml and R.json.",
};

/* one of two words; 0 for the first, 1 for the second */
static enum cli_result choose(const char *option, const char *word, const char *first, const char *second,
                              int *chosen) {
  if (!word) return CLI_RUN;
  if (strcmp(word, first) != 0 && strcmp(word, second) != 0)
    return cli_complain("--%s is \"%s\" or \"%s\", not \"%s\"", option, first, second, word);
  *chosen = strcmp(word, second) == 0;
  return CLI_RUN;
}

/* "ORDER,SECONDS" */
static enum cli_result read_window(const char *text, tl_window *window) {
  const char *end;
  double order, length_s;

  if (decimal_parse(text, &order, &end) != DECIMAL_OK || *end != ',' ||
      decimal_parse(end + 1, &length_s, &end) != DECIMAL_OK || *end != '\0')
    return cli_complain("--window is ORDER,SECONDS, such as 20,1, not \"%s\"", text);
  if (order != (int)order || order < 2 || order > TL_WINDOW_MAX_ORDER || !(length_s > 0.0))
    return cli_complain("--window: the order is a whole number from 2 to %d, the length above 0",
                        TL_WINDOW_MAX_ORDER);
  *window = (tl_window){(int)order, length_s};
  return CLI_RUN;
}

static enum cli_result count(const char *option, uint64_t asked_for, uint64_t least, int *target) {
  if (asked_for == UINT64_MAX) return CLI_RUN;
  if (asked_for < least || asked_for > 1000000)
    return cli_complain("--%s is a whole number from %d to 1000000", option, (int)least);
  *target = (int)asked_for;
  return CLI_RUN;
}

static enum cli_result read_settings(struct fit_settings *s, tl_window *window) {
  tl_pso_settings *swarm = &s->identify.swarm;
  int equal = 0, inertia = 0, ring = swarm->topology == TL_PSO_RING;

  /* JSON's whole numbers have a sign */
  if (asked.seed > INT64_MAX) return cli_complain("--seed is at most %" PRId64, INT64_MAX);
  if (asked.window && read_window(asked.window, window) != CLI_RUN) return CLI_USAGE;
  if (choose("weights", asked.weights, "noise", "equal", &equal) != CLI_RUN) return CLI_USAGE;
  if (choose("loss", asked.loss, "square", "huber", &s->huber) != CLI_RUN) return CLI_USAGE;
  if (choose("swarm-form", asked.form, "constriction", "inertia", &inertia) != CLI_RUN) return CLI_USAGE;
  if (choose("topology", asked.topology, "global", "ring", &ring) != CLI_RUN) return CLI_USAGE;
  if (count("particles", asked.particles, 2, &swarm->particles) != CLI_RUN) return CLI_USAGE;
  if (count("iterations", asked.iterations, 1, &swarm->iterations) != CLI_RUN) return CLI_USAGE;
  if (count("restarts", asked.restarts, 1, &swarm->restarts) != CLI_RUN) return CLI_USAGE;
  if (count("threads", asked.threads, 1, &s->threads) != CLI_RUN) return CLI_USAGE;
  s->identify.weighting = equal ? TL_WEIGHT_EQUAL : TL_WEIGHT_NOISE;
  swarm->form = inertia ? TL_PSO_INERTIA : TL_PSO_CONSTRICTION;
  swarm->topology = ring ? TL_PSO_RING : TL_PSO_GLOBAL;
  swarm->seed = asked.seed;
  return CLI_RUN;
}

/* ---- recordings --------------------------------------------------------------- */

/* Is gravity fitted? Not where the model has none, nor where no recording shows an angle; recordings
 * with and without an angle would hold different models of gravity. */
static int gravity_is_seen(const struct model_file *file, const struct inputs *in, int *seen,
                           struct app_error *error) {
  int with = -1, without = -1;

  *seen = 0;
  if (!tl_has_gravity(&file->model)) return 0;
  for (int i = 0; i < in->n; i++)
    *(stream_regression(in->stream[i])->layout.position[0] != TL_CHANNEL_COUNT ? &with : &without) = i;
  *seen = with >= 0;
  if (with >= 0 && without >= 0)
    return app_fail(error, APP_BAD_INPUT, "%s has joint_rad and %s has not: gravity cannot be fitted to both",
                    recording_path(in->recording[with]), recording_path(in->recording[without]));
  if (without >= 0)
    app_note("%s has no joint_rad: gravity is not fitted", recording_path(in->recording[without]));
  return 0;
}

/* bounds from the file; gravity is held where it cannot be fitted */
static void hold_and_bound(const struct model_file *file, int gravity_seen, tl_identify_settings *s) {
  int n;
  const tl_parameter *table = tl_parameters(&file->model, &n);

  for (int i = 0; i < n; i++) {
    s->bounded[i] = file->bounded[i];
    s->lower[i] = file->lower[i];
    s->upper[i] = file->upper[i];
    if (strncmp(table[i].name, "gravity_", 8) == 0 && !gravity_seen) s->fixed[i] = 1;
  }
}

/* ---- the run ------------------------------------------------------------------- */

/* what would be written over: no two results in one file, none in a file that is read (but the model
 * itself, which may be replaced by the identified one) */
static enum cli_result check_results(char *const *path, int n) {
  const struct cli_file result[] = {{"out", asked.out}, {"report", asked.report}, {"html", asked.html}};

  if (cli_keep_apart(result, 3) != CLI_RUN) return CLI_USAGE;
  for (int k = 0; k < n; k++)
    if (cli_keep_input(result, 3, path[k], "a recording") != CLI_RUN) return CLI_USAGE;
  return cli_keep_input(result + 1, 2, asked.model, "the model");
}

/* better known before the search than after it */
static int probe_results(struct app_error *error) {
  if (output_probe(asked.out, error) != 0) return -1;
  if (asked.report && output_probe(asked.report, error) != 0) return -1;
  return asked.html ? output_probe(asked.html, error) : 0;
}

/* the largest first: where the disk is full, nothing else has been replaced yet */
static int write_results(const struct report_input *in, const struct picture *picture,
                         struct app_error *error) {
  struct model_file fitted = *in->prior;

  tl_parameters_set(&fitted.model, in->fit->result.value);
  if (asked.html && picture_write(picture, asked.html, in, error) != 0) return -1;
  if (asked.report && report_write_json(asked.report, in, error) != 0) return -1;
  return model_file_write(asked.out, &fitted, "identified by talus-identify", error);
}

static int identify(const struct model_file *file, struct fit_settings *settings, const struct inputs *in,
                    char **path, struct app_error *error) {
  struct picture *picture = asked.html ? picture_new(in->n, tl_joint_count(&file->model)) : NULL;
  struct fit *fit = malloc(sizeof *fit);
  struct report_input report = {fit, file, in->stream, (const char *const *)path, in->n, asked.seed};
  int result = fit && (picture || !asked.html) ? 0 : app_fail(error, APP_FAILED, "out of memory");

  if (result == 0) result = probe_results(error);
  if (result == 0)
    result = fit_run(fit, &file->model, settings, in, picture ? picture_trace : NULL, picture, error);
  if (result == 0) result = write_results(&report, picture, error);
  if (result == 0 && !asked.quiet) report_say(&report);
  if (result == 0 && asked.quiet) report_warn(&report);
  picture_free(picture);
  free(fit);
  return result;
}

int main(int argc, char **argv) {
  struct fit_settings settings = {.identify = tl_identify_defaults(), .threads = 1};
  struct inputs in = {NULL, NULL, 0, NULL, NULL, 0};
  struct model_file file;
  struct app_error error;
  tl_window window;
  int first, result, gravity_seen = 0;

  asked.seed = 1;
  asked.threads = asked.particles = asked.iterations = asked.restarts = UINT64_MAX;
  switch (cli_parse(&program, argc, argv, &first)) {
  case CLI_RUN: break;
  case CLI_DONE: return APP_OK;
  case CLI_USAGE: return APP_BAD_INPUT;
  }
  progress_show(!asked.quiet);
  if (read_settings(&settings, &window) != CLI_RUN) return APP_BAD_INPUT;
  if (check_results(argv + first, argc - first) != CLI_RUN) return APP_BAD_INPUT;
  if (model_file_read(asked.model, &file, &error) != 0) return app_exit(&error);
  if (!asked.window && file.has_window) window = file.window;
  in.file = &file;
  in.window = asked.window || file.has_window ? &window : NULL;
  in.workers = asked.threads != UINT64_MAX ? (int)asked.threads : 0;
  result = inputs_open(&in, argv + first, argc - first, &error);
  if (result == 0) result = gravity_is_seen(&file, &in, &gravity_seen, &error);
  if (result == 0) {
    hold_and_bound(&file, gravity_seen, &settings.identify);
    result = identify(&file, &settings, &in, argv + first, &error);
  }
  inputs_close(&in);
  return result == 0 ? APP_OK : app_exit(&error);
}
