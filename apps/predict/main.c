/* talus-predict: what a model predicts at a recording's samples. */
#include "common/cli.h"
#include "model/model_file.h"
#include "predict.h"

static struct { const char *model, *out; } asked;

static const struct cli_option options[] = {
    {"model", 'm', CLI_TEXT, &asked.model, 1, "M.yaml", "the model"},
    {"out", 'o', CLI_TEXT, &asked.out, 0, "P.csv", "where to write (default: standard output)"},
};

static const struct cli_program program = {
    .name = "talus-predict",
    .summary = "predicts what a recording's current (or load) column would show, from its angles alone",
    .arguments = "REC.csv",
    .min_arguments = 1,
    .max_arguments = 1,
    .option = options,
    .options = sizeof options / sizeof options[0],
    .more = "One row for each row of the recording, at the same times. Rows without support (gaps,\n"
            "valid = 0, the ends) hold the nearest estimate.",
};

/* the prediction must not be written over what it is made from */
static enum cli_result check_result(const char *recording) {
  if (!asked.out) return CLI_RUN;
  if (output_same(asked.out, recording))
    return cli_complain("--out: %s is the recording, it would be lost", recording);
  if (output_same(asked.out, asked.model))
    return cli_complain("--out: %s is the model, it would be lost", asked.model);
  return CLI_RUN;
}

/* gravity needs the angle */
static void note_gravity(const tl_model *model, const struct stream *stream, const char *path) {
  if (tl_has_gravity(model) && stream_regression(stream)->layout.position[0] == TL_NO_CHANNEL)
    app_note("%s has no joint_rad: gravity is not predicted", path);
}

static int predict(const struct model_file *file, struct recording *recording, struct app_error *error) {
  struct stream *stream =
      stream_open(recording, &file->model, &file->score, file->has_window ? &file->window : NULL, error);
  struct output *out;
  int result, ready = 0;

  if (stream && stream_set_effects(stream, file->effect, file->effects, error) == 0) ready = 1;
  if (ready) note_gravity(&file->model, stream, recording_path(recording));
  out = ready ? output_open(asked.out, error) : NULL;
  result = out ? predict_write(out, recording, stream, &file->model, error) : -1;

  if (out && result == 0)
    result = output_commit(out, error);
  else
    output_abandon(out);
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
  if (check_result(argv[first]) != CLI_RUN) return APP_BAD_INPUT;
  if (model_file_read(asked.model, &file, &error) != 0) return app_exit(&error);
  recording = recording_open(argv[first], file.model.plant, &error);
  if (!recording) return app_exit(&error);
  result = predict(&file, recording, &error);
  recording_close(recording);
  return result == 0 ? APP_OK : app_exit(&error);
}
