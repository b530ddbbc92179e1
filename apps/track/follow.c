/* follow.c: the markers through all pictures of a video. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/cli.h"
#include "common/json_file.h"
#include "common/progress.h"
#include "track/commands.h"
#include "track/overlay.h"
#include "track/summary.h"
#include "track/track_file.h"

#define RUNS 65536

static struct {
  const char *setup, *out, *report, *overlay, *sheet;
  uint64_t pictures;
} asked;

static const struct cli_option options[] = {
    {"setup", 's', CLI_TEXT, &asked.setup, 1, "SETUP.yaml",
     "colours, view and lens (talus-track calibrate makes it)"},
    {"out", 'o', CLI_TEXT, &asked.out, 0, "TRACK.csv", "where to write (default: standard output)"},
    {"report", 0, CLI_TEXT, &asked.report, 0, "R.json", "the summary, with the intervals of lost markers"},
    {"overlay", 0, CLI_TEXT, &asked.overlay, 0, "O.avi", "the video with what was seen drawn into it"},
    {"sheet", 0, CLI_TEXT, &asked.sheet, 0, "S.png",
     "pictures with all markers, with one partly hidden, with one lost"},
    {"pictures", 0, CLI_WHOLE, &asked.pictures, 0, "N",
     "stop after N pictures (a camera goes on until then)"},
};

static const struct cli_program program = {
    .name = "talus-track",
    .summary = "follows coloured markers in a video, to sub-pixels, and gives the angles of shank and foot",
    .example = "talus-track --setup setup.yaml --out track.csv film.mp4\n"
               "talus-track calibrate --out setup.yaml --shank-length 0.3615 film.mp4\n"
               "talus-track align --recording walk.csv --out merged.csv track.csv",
    .arguments = "VIDEO",
    .min_arguments = 1,
    .max_arguments = 1,
    .option = options,
    .options = sizeof options / sizeof options[0],
    .more = "VIDEO is a file, or camera:0 for a live camera.\n\n"
            "talus-track calibrate --help   colours and view from a first picture\n"
            "talus-track lens --help        the lens from pictures of a chessboard\n"
            "talus-track tilt --help        the camera's tilt against the plane of motion, from a track\n"
            "talus-track align --help       the camera's clock against a recording, and both merged",
};

struct follow {
  const char *path;
  struct setup setup;
  tl_marker_classes classes;
  tl_marker_state state;
  tl_marker_run *run;
  struct face_video *video;
  struct output *out;
  struct summary summary;
  struct overlay overlay;
  struct progress progress;
};

/* mean brightness of the lamp's inside, 0..1 */
static double lamp_of(const struct setup *setup, const struct face_picture *p) {
  const double r = 0.6 * setup->lamp_px[2];
  double sum = 0.0;
  long n = 0;
  for (int y = (int)ceil(setup->lamp_px[1] - r); y <= setup->lamp_px[1] + r; y++)
    for (int x = (int)ceil(setup->lamp_px[0] - r); x <= setup->lamp_px[0] + r; x++) {
      if (x < 0 || y < 0 || x >= p->width || y >= p->height) continue;
      const uint8_t *pixel = p->pixel + (size_t)y * p->stride + 3 * (size_t)x;
      sum += pixel[0] + pixel[1] + pixel[2];
      n += 3;
    }
  return n ? sum / (255.0 * (double)n) : (double)NAN;
}

static int one_picture(struct follow *f, const struct face_picture *p, struct app_error *error) {
  struct track_row row = {.t_s = p->t_s, .lamp = (double)NAN};
  tl_marker_sample straight[TL_MARKER_MAX];
  const tl_image image = {p->pixel,  p->stride * (size_t)(p->height - 1) + 3 * (size_t)p->width,
                          p->stride, p->width,
                          p->height, 3};
  const tl_status status =
      tl_marker_track(&f->setup.mark, &f->classes, &f->state, &image, p->t_s, row.sample, f->run, RUNS);
  if (status != TL_OK)
    return app_fail(error, APP_BAD_INPUT, "%s: picture at %.4f s: %s", f->path, p->t_s,
                    tl_status_text(status));
  if (f->setup.has_lamp) row.lamp = lamp_of(&f->setup, p);
  if (f->setup.is_leg) {
    setup_undistort(&f->setup, row.sample, straight);
    tl_marker_angles_from(&f->setup.view, straight, &row.angles);
  }
  track_file_row(f->out, &f->setup, &row);
  summary_add(&f->summary, &row);
  return overlay_add(&f->overlay, p, &row, error);
}

static int all_pictures(struct follow *f, struct app_error *error) {
  const double count = face_video_count(f->video);
  const double all =
      asked.pictures && (count <= 0.0 || (double)asked.pictures < count) ? (double)asked.pictures : count;
  struct face_picture picture;
  char text[FACE_TEXT];
  int more = 1;
  while (!asked.pictures || f->summary.pictures < asked.pictures) {
    more = face_video_next(f->video, &picture, text);
    if (more <= 0) break;
    if (one_picture(f, &picture, error) != 0) return -1;
    if (all > 0.0) progress_update(&f->progress, (double)f->summary.pictures / all);
  }
  return more < 0 ? app_fail(error, APP_BAD_INPUT, "%s: %s", f->path, text) : 0;
}

static int begin(struct follow *f, struct app_error *error) {
  char text[FACE_TEXT];
  if (setup_read(asked.setup, &f->setup, error) != 0) return -1;
  if (tl_marker_classes_init(&f->classes, f->setup.mark.color, f->setup.mark.colors) != TL_OK ||
      tl_marker_start(&f->setup.mark, &f->state) != TL_OK)
    return app_fail(error, APP_BAD_INPUT, "%s: markers that cannot be", asked.setup);
  f->run = malloc(RUNS * sizeof *f->run);
  if (!f->run) return app_fail(error, APP_FAILED, "out of memory");
  f->video = face_video_open(f->path, text);
  if (!f->video) return app_fail(error, APP_BAD_INPUT, "%s: %s", f->path, text);
  if (summary_begin(&f->summary, &f->setup, error) != 0) return -1;
  overlay_begin(&f->overlay, &f->setup, asked.overlay, asked.sheet, face_video_rate(f->video));
  f->out = output_open(asked.out, error);
  if (!f->out) return -1;
  track_file_header(f->out, &f->setup);
  return 0;
}

static int write_report(struct follow *f, struct app_error *error) {
  json_t *report = summary_json(&f->summary, f->path);
  const int result = asked.report ? json_file_write(asked.report, report, error) : 0;
  json_decref(report);
  return result;
}

static int finish(struct follow *f, struct app_error *error) {
  struct output *out = f->out;
  if (summary_judge(&f->summary, f->path, error) != 0) return -1;
  if (write_report(f, error) != 0 || overlay_commit(&f->overlay, error) != 0) return -1;
  f->out = NULL;
  if (output_commit(out, error) != 0) return -1;
  summary_print(&f->summary, f->path);
  return 0;
}

int command_follow(int argc, char **argv) {
  struct app_error error;
  struct follow follow;
  int first, result;
  memset(&follow, 0, sizeof follow);
  switch (cli_parse(&program, argc, argv, &first)) {
  case CLI_RUN: break;
  case CLI_DONE: return APP_OK;
  case CLI_USAGE: return APP_BAD_INPUT;
  }
  follow.path = argv[first];
  result = begin(&follow, &error);
  if (result == 0) {
    progress_begin(&follow.progress, "following markers", NULL);
    result = all_pictures(&follow, &error);
    progress_end(&follow.progress);
  }
  if (result == 0) result = finish(&follow, &error);
  output_abandon(follow.out);
  overlay_end(&follow.overlay);
  summary_end(&follow.summary);
  face_video_close(follow.video);
  free(follow.run);
  return result == 0 ? APP_OK : app_exit(&error);
}
