/* talus-predict: what a model predicts at a recording's samples. */
#include "common/cli.h"
#include "model/model_file.h"
#include "predict.h"
#include "report.h"

static struct { const char *model, *out, *report, *html; } asked;

static const struct cli_option options[] = {
    {"model", 'm', CLI_TEXT, &asked.model, 1, "M.yaml", "the model"},
    {"out", 'o', CLI_TEXT, &asked.out, 0, "P.csv",
     "where to write the prediction (default: standard output;\nwith --report or --html nowhere)"},
    {"report", 'r', CLI_TEXT, &asked.report, 0, "P.json",
     "the prediction's error at each joint, for machines"},
    {"html", 0, CLI_TEXT, &asked.html, 0, "P.html", "measured against predicted torque, as a page"},
};

static const struct cli_program program = {
    .name = "talus-predict",
    .summary = "predicts what a recording's current (or load) column would show, from its angles alone",
    .example = "talus-predict --model fitted.yaml --out predicted.csv run.csv\n"
               "talus-predict --model fitted.yaml --report errors.json --html errors.html run.csv",
    .arguments = "REC.csv",
    .min_arguments = 1,
    .max_arguments = 1,
    .option = options,
    .options = sizeof options / sizeof options[0],
    .more = "One row for each row of the recording, at the same times. Rows without support (gaps,\n"
            "valid = 0, the ends) hold the nearest estimate.",
};

/* what would be written over */
static enum cli_result check_results(const char *recording) {
  const struct cli_file result[] = {{"out", asked.out}, {"report", asked.report}, {"html", asked.html}};

  if (cli_keep_apart(result, 3) != CLI_RUN) return CLI_USAGE;
  if (cli_keep_input(result, 3, recording, "the recording") != CLI_RUN) return CLI_USAGE;
  return cli_keep_input(result, 3, asked.model, "the model");
}

/* better known before the work than after it */
static int probe_results(struct app_error *error) {
  if (asked.report && output_probe(asked.report, error) != 0) return -1;
  return asked.html ? output_probe(asked.html, error) : 0;
}

/* gravity needs the angle */
static void note_gravity(const tl_model *model, const struct stream *stream, const char *path) {
  if (tl_has_gravity(model) && stream_regression(stream)->layout.position[0] == TL_NO_CHANNEL)
    app_note("%s has no joint_rad: gravity is not predicted", path);
}

/* the prediction's error, where it was asked for */
static int write_error(const struct report *report, struct app_error *error) {
  if (asked.html && report_write_page(report, asked.html, error) != 0) return -1;
  return asked.report ? report_write_json(report, asked.report, error) : 0;
}

/* the prediction itself takes its name last: where the disk is full it is what it was */
static int write_all(const struct report *report, struct recording *recording, struct stream *stream,
                     struct app_error *error) {
  const int scored = asked.report || asked.html;
  struct output *out;

  if (scored && !asked.out) return write_error(report, error);
  out = output_open(asked.out, error);
  if (!out) return -1;
  if (predict_write(out, recording, stream, report->model, error) == 0 &&
      (!scored || write_error(report, error) == 0))
    return output_commit(out, error);
  output_abandon(out);
  return -1;
}

static int score_and_write(const struct model_file *file, struct recording *recording, struct stream *stream,
                           struct app_error *error) {
  const int scored = asked.report || asked.html;
  struct report report = {.model = &file->model};
  int result = probe_results(error);

  if (result == 0 && scored) result = report_make(&report, &file->model, stream, asked.html != NULL, error);
  if (result == 0) result = write_all(&report, recording, stream, error);
  if (result == 0 && scored) report_say(&report);
  report_free(&report);
  return result;
}

static int predict(const struct model_file *file, struct recording *recording, struct app_error *error) {
  struct stream *stream =
      stream_open(recording, &file->model, &file->score, file->has_window ? &file->window : NULL, error);
  int result = stream ? stream_set_effects(stream, file->effect, file->effects, error) : -1;

  if (result == 0) {
    note_gravity(&file->model, stream, recording_path(recording));
    result = score_and_write(file, recording, stream, error);
  }
  stream_close(stream);
  return result;
}

int main(int argc, char **argv) {
  struct recording *recording;
  struct model_file file;
  struct app_error error;
  int first, result;

  switch (cli_parse(&program, argc, argv, &first)) {
  case CLI_RUN: break;
  case CLI_DONE: return APP_OK;
  case CLI_USAGE: return APP_BAD_INPUT;
  }
  if (check_results(argv[first]) != CLI_RUN) return APP_BAD_INPUT;
  if (model_file_read(asked.model, &file, &error) != 0) return app_exit(&error);
  recording = recording_open(argv[first], file.model.plant, &error);
  if (!recording) return app_exit(&error);
  result = predict(&file, recording, &error);
  recording_close(recording);
  return result == 0 ? APP_OK : app_exit(&error);
}
