/* tilt.c: the plane's slope against the camera, from a track. */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/cli.h"
#include "talus/math.h"
#include "track/commands.h"
#include "track/setup.h"
#include "track/table.h"

static struct { const char *setup, *out; } asked;

static const struct cli_option options[] = {
    {"setup", 's', CLI_TEXT, &asked.setup, 1, "SETUP.yaml",
     "the setup the track was made with; it needs a lens"},
    {"out", 'o', CLI_TEXT, &asked.out, 1, "SETUP.yaml",
     "the setup with the tilt, in the same folder; may be the same file"},
};

static const struct cli_program program = {
    .name = "talus-track tilt",
    .summary = "finds the camera's tilt against the plane of motion: with the right one the links keep their "
               "lengths",
    .example = "talus-track tilt --setup setup.yaml --out setup.yaml track.csv",
    .arguments = "TRACK.csv",
    .min_arguments = 1,
    .max_arguments = 1,
    .option = options,
    .options = sizeof options / sizeof options[0],
};

static const char *const names[] = {"time_s",     "knee_x_px",       "knee_y_px",     "ankle_x_px",
                                    "ankle_y_px", "heel_x_px",       "heel_y_px",     "toe_x_px",
                                    "toe_y_px",   "shank_sigma_rad", "foot_sigma_rad"};
enum { COLUMNS = sizeof names / sizeof names[0] };

/* Centres, without distortion, of the pictures in which both angles are valid. */
static size_t whole_points(const struct setup *setup, const struct table *t, double (*point)[4][2]) {
  size_t n = 0;
  for (size_t row = 0; row < t->rows; row++) {
    if (!(t->column[9][row] > 0.0 && t->column[10][row] > 0.0)) continue;
    for (int k = 0; k < 8; k++) point[n][k / 2][k % 2] = t->column[1 + k][row];
    face_lens_undistort(&setup->lens, point[n], 4);
    n++;
  }
  return n;
}

/* Directions of both links' lines at calibration. */
static void lines_of(const struct setup *setup, double line_rad[2]) {
  double point[4][2];
  memcpy(point, setup->mark.start_px, sizeof point);
  face_lens_undistort(&setup->lens, point, 4);
  for (int k = 0; k < 2; k++)
    line_rad[k] = tl_marker_direction(&setup->view, point[(ptrdiff_t)2 * k], point[2 * k + 1]);
}

/* The picture of the calibration shows the pose that it was given, with the new tilt, too. Without a pose both offsets are 0 and
 * angles stay those of the lines. */
static void keep_pose(struct setup *setup, const double old_rad[2]) {
  double new_rad[2];
  if (setup->view.shank_offset_rad == 0.0 && setup->view.foot_offset_rad == 0.0) return;
  lines_of(setup, new_rad);
  setup->view.shank_offset_rad += remainder(new_rad[0] - old_rad[0], 2.0 * TL_PI);
  setup->view.foot_offset_rad += remainder(new_rad[1] - old_rad[1], 2.0 * TL_PI);
}

static int fit(struct setup *setup, const struct table *t, const char *path, struct app_error *error) {
  double sigma[2], line_rad[2];
  double(*point)[4][2] = malloc((t->rows + 1) * sizeof *point);
  if (!point) return app_fail(error, APP_FAILED, "out of memory");
  const size_t n = whole_points(setup, t, point);
  lines_of(setup, line_rad);
  const tl_status status = tl_marker_fit_tilt(&setup->view, (const double(*)[4][2])point, n, sigma);
  free(point);
  if (status != TL_OK)
    return app_fail(error, APP_BAD_INPUT, "%s: no tilt from %zu pictures with all markers: %s", path, n,
                    tl_status_text(status));
  keep_pose(setup, line_rad);
  fprintf(stderr, "tilt %.5f +- %.5f to the right, %.5f +- %.5f down, from %zu pictures\n",
          setup->view.tilt[0], sigma[0], setup->view.tilt[1], sigma[1], n);
  return setup_write(asked.out, setup, error);
}

static int from_track(const char *path, struct app_error *error) {
  struct setup setup;
  struct table table;
  if (setup_read(asked.setup, &setup, error) != 0) return -1;
  if (!setup.is_leg || !setup.lens_path[0])
    return app_fail(error, APP_BAD_INPUT, "%s: the tilt needs a leg's markers, a view and a lens",
                    asked.setup);
  if (table_read(path, names, COLUMNS, COLUMNS, &table, error) != 0) return -1;
  const int result = fit(&setup, &table, path, error);
  table_free(&table);
  return result;
}

int command_tilt(int argc, char **argv) {
  struct app_error error;
  int first;
  switch (cli_parse(&program, argc, argv, &first)) {
  case CLI_RUN: break;
  case CLI_DONE: return APP_OK;
  case CLI_USAGE: return APP_BAD_INPUT;
  }
  return from_track(argv[first], &error) == 0 ? APP_OK : app_exit(&error);
}
