/* lens.c: the lens from pictures of a chessboard. */
#include <stdio.h>
#include <stdlib.h>

#include "common/cli.h"
#include "common/error.h"
#include "track/commands.h"
#include "track/opencv_face.h"

static struct {
  const char *out;
  uint64_t columns, rows;
  double square;
} asked = {.columns = 9, .rows = 6, .square = 1.0};

static const struct cli_option options[] = {
    {"out", 'o', CLI_TEXT, &asked.out, 1, "LENS.yaml", "where to write, as OpenCV writes it"},
    {"columns", 0, CLI_WHOLE, &asked.columns, 0, "N", "inner corners of the board across (default 9)"},
    {"rows", 0, CLI_WHOLE, &asked.rows, 0, "N", "inner corners of the board down (default 6)"},
    {"square", 0, CLI_NUMBER, &asked.square, 0, "M",
     "width of a square; only the file's own poses depend on it (default 1)"},
};

static const struct cli_program program = {
    .name = "talus-track lens",
    .summary = "calibrates a lens from pictures of a chessboard",
    .example = "talus-track lens --out lens.yaml left*.jpg",
    .arguments = "PICTURE...",
    .min_arguments = 3,
    .max_arguments = CLI_ANY,
    .option = options,
    .options = sizeof options / sizeof options[0],
};

static void say_lens(const struct face_lens *lens, int count) {
  fprintf(stderr,
          "%d of %d pictures show the board; focal lengths %.2f, %.2f px, centre %.2f, %.2f px; reprojection "
          "error %.4f px\n",
          lens->pictures, count, lens->focal_px[0], lens->focal_px[1], lens->center_px[0], lens->center_px[1],
          lens->rms_px);
}

static int make_lens(char **path, int count, struct app_error *error) {
  char text[FACE_TEXT];
  struct face_lens lens;
  uint8_t *found = calloc((size_t)count, 1);
  if (!found) return app_fail(error, APP_FAILED, "out of memory");
  int result = face_lens_calibrate((const char *const *)path, count, (int)asked.columns, (int)asked.rows,
                                   asked.square, &lens, found, text);
  if (result != 0) app_fail(error, APP_BAD_INPUT, "%s", text);
  for (int i = 0; i < count && result == 0; i++)
    if (!found[i]) app_note("%s: no board in it", path[i]);
  free(found);
  if (result == 0 && face_lens_write(asked.out, &lens, text) != 0)
    result = app_fail(error, APP_FAILED, "%s: %s", asked.out, text);
  if (result == 0) say_lens(&lens, count);
  return result;
}

int command_lens(int argc, char **argv) {
  struct app_error error;
  int first;
  switch (cli_parse(&program, argc, argv, &first)) {
  case CLI_RUN: break;
  case CLI_DONE: return APP_OK;
  case CLI_USAGE: return APP_BAD_INPUT;
  }
  if (asked.columns < 2 || asked.rows < 2 || asked.columns > 100 || asked.rows > 100 ||
      !(asked.square > 0.0)) {
    cli_complain("--columns and --rows: expected 2 to 100, --square above 0");
    return APP_BAD_INPUT;
  }
  return make_lens(argv + first, argc - first, &error) == 0 ? APP_OK : app_exit(&error);
}
