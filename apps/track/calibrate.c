/* calibrate.c: colours and view from one picture of a video. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/cli.h"
#include "common/decimal.h"
#include "common/output.h"
#include "talus/math.h"
#include "track/colors.h"
#include "track/commands.h"
#include "track/setup.h"

static struct {
  const char *out, *points, *plumb, *pose, *lens, *lamp, *sheet;
  int counterclockwise;
  double at_s, shank_m;
} asked = {.shank_m = 0.0};

static const struct cli_option options[] = {
    {"out", 'o', CLI_TEXT, &asked.out, 1, "SETUP.yaml", "where to write"},
    {"points", 0, CLI_TEXT, &asked.points, 0, "NAME=X,Y...",
     "where markers are, parted by blanks: their colours are sampled there\n"
     "(default: the four round coloured things, as knee, ankle, heel, toe)"},
    {"at", 0, CLI_NUMBER, &asked.at_s, 0, "S",
     "take the first picture at or after this time (default: the first)"},
    {"shank-length", 0, CLI_NUMBER, &asked.shank_m, 0, "M",
     "distance of knee and ankle marker [m]; a leg needs it"},
    {"plumb", 0, CLI_TEXT, &asked.plumb, 0, "X,Y,X,Y",
     "upper and lower point of a plumb line (default: the picture is upright)"},
    {"pose", 0, CLI_TEXT, &asked.pose, 0, "SHANK,FOOT",
     "the angles [rad] in this picture, so that the markers' offsets are known"},
    {"counterclockwise", 0, CLI_FLAG, &asked.counterclockwise, 0, NULL,
     "positive angles turn counterclockwise in the picture"},
    {"lens", 0, CLI_TEXT, &asked.lens, 0, "LENS.yaml",
     "OpenCV's calibration of the lens (talus-track lens); its path from SETUP.yaml"},
    {"lamp", 0, CLI_TEXT, &asked.lamp, 0, "X,Y,RADIUS", "a sync lamp in the picture"},
    {"sheet", 0, CLI_TEXT, &asked.sheet, 0, "S.png", "the picture with what was found"},
};

static const struct cli_program program = {
    .name = "talus-track calibrate",
    .summary = "takes the markers' colours and places from one picture, and how the camera sees the leg",
    .example = "talus-track calibrate --out setup.yaml --shank-length 0.3615 --sheet found.png film.mp4",
    .arguments = "VIDEO",
    .min_arguments = 1,
    .max_arguments = 1,
    .option = options,
    .options = sizeof options / sizeof options[0],
};

/* n numbers, parted by commas, to the end of the text */
static int numbers_of(const char *text, double *x, int n) {
  for (int i = 0; i < n; i++) {
    const char *end;
    if (decimal_parse(text, &x[i], &end) != DECIMAL_OK) return -1;
    if (*end != (i + 1 < n ? ',' : '\0')) return -1;
    text = end + 1;
  }
  return 0;
}

/* ---- which spot is which marker -------------------------------------------------- */

static void set_marker(struct setup *setup, int m, const char *name, const struct spot *spot) {
  snprintf(setup->name[m], SETUP_NAME, "%s", name);
  setup->mark.start_px[m][0] = spot->x_px;
  setup->mark.start_px[m][1] = spot->y_px;
  setup->mark.radius_px[m] = spot->radius_px;
}

static int sample_points(const struct face_picture *p, struct setup *setup, struct spot spot[TL_MARKER_MAX],
                         struct app_error *error) {
  char name[SETUP_NAME], place[64];
  const char *at = asked.points;
  double xy[2];
  int used, m = 0;
  for (; sscanf(at, " %23[^= ]=%63s%n", name, place, &used) == 2; at += used, m++) {
    if (m == TL_MARKER_MAX || numbers_of(place, xy, 2) != 0) break;
    if (colors_at(p, xy[0], xy[1], &spot[m]) != 0)
      return app_fail(error, APP_BAD_INPUT, "--points: at %s there is no colour strong enough for marker %s",
                      place, name);
    set_marker(setup, m, name, &spot[m]);
  }
  if (m == 0 || at[strspn(at, " ")])
    return app_fail(error, APP_BAD_INPUT, "--points: expected one to %d of NAME=X,Y, found '%.60s'",
                    TL_MARKER_MAX, at);
  return m;
}

static void swap(struct spot *a, struct spot *b) {
  const struct spot c = *a;
  *a = *b;
  *b = c;
}

static double apart(const struct spot *a, const struct spot *b) {
  return hypot(a->x_px - b->x_px, a->y_px - b->y_px);
}

/* A leg that hangs: the knee is highest, the ankle nearest to it, the heel nearer to the ankle than the toe. */
static void sort_leg(struct spot spot[4]) {
  for (int k = 1; k < 4; k++)
    if (spot[k].y_px < spot[0].y_px) swap(&spot[0], &spot[k]);
  for (int k = 2; k < 4; k++)
    if (apart(&spot[k], &spot[0]) < apart(&spot[1], &spot[0])) swap(&spot[1], &spot[k]);
  if (apart(&spot[2], &spot[1]) > apart(&spot[3], &spot[1])) swap(&spot[2], &spot[3]);
}

static int find_leg(const struct face_picture *p, struct setup *setup, struct spot spot[TL_MARKER_MAX],
                    struct app_error *error) {
  static const char *const name[4] = {"knee", "ankle", "heel", "toe"};
  struct spot found[16];
  const int n = colors_find(p, found, 16);
  if (n < 4)
    return app_fail(
        error, n < 0 ? APP_FAILED : APP_BAD_INPUT,
        "%d round coloured things in the picture, expected the 4 markers of a leg (--points names places)",
        n < 0 ? 0 : n);
  if (n > 4)
    app_note("%d round coloured things in the picture: the four largest are taken (--sheet shows which)", n);
  memcpy(spot, found, 4 * sizeof *spot);
  sort_leg(spot);
  for (int m = 0; m < 4; m++) set_marker(setup, m, name[m], &spot[m]);
  return 4;
}

/* ---- the view -------------------------------------------------------------------- */

static int set_plumb(struct setup *setup, struct app_error *error) {
  double line[4];
  if (!asked.plumb) return 0;
  if (numbers_of(asked.plumb, line, 4) != 0 || !(line[3] > line[1]))
    return app_fail(error, APP_BAD_INPUT, "--plumb: expected X,Y,X,Y, the lower point second");
  setup->view.vertical_rad = tl_marker_direction(&setup->view, line, line + 2);
  return 0;
}

/* What the markers' lines show in a pose that is known. */
static int set_pose(struct setup *setup, struct app_error *error) {
  tl_marker_sample sample[4], straight[4];
  tl_marker_angles angles;
  double pose[2];
  if (!asked.pose) {
    app_note("without --pose the angles are those of the markers' lines: knee to ankle, heel to toe");
    return 0;
  }
  if (numbers_of(asked.pose, pose, 2) != 0)
    return app_fail(error, APP_BAD_INPUT, "--pose: expected SHANK,FOOT in rad");
  memset(sample, 0, sizeof sample);
  for (int m = 0; m < 4; m++) {
    sample[m].flags = TL_MARKER_SEEN;
    sample[m].x_px = setup->mark.start_px[m][0];
    sample[m].y_px = setup->mark.start_px[m][1];
  }
  setup_undistort(setup, sample, straight);
  tl_marker_angles_from(&setup->view, straight, &angles);
  setup->view.shank_offset_rad = angles.shank_rad - pose[0];
  setup->view.foot_offset_rad = angles.foot_rad - pose[1];
  return 0;
}

/* The places to sub-pixels, as the tracker will see them. */
static void refine(const struct face_picture *p, struct setup *setup) {
  static tl_marker_run run[65536];
  const tl_image image = {p->pixel,  p->stride * (size_t)(p->height - 1) + 3 * (size_t)p->width,
                          p->stride, p->width,
                          p->height, 3};
  tl_marker_sample sample[TL_MARKER_MAX];
  tl_marker_classes classes;
  tl_marker_state state;
  if (tl_marker_classes_init(&classes, setup->mark.color, setup->mark.colors) != TL_OK) return;
  if (tl_marker_start(&setup->mark, &state) != TL_OK) return;
  if (tl_marker_track(&setup->mark, &classes, &state, &image, 0.0, sample, run, 65536) != TL_OK) return;
  for (int m = 0; m < setup->mark.markers; m++) {
    const double moved =
        hypot(sample[m].x_px - setup->mark.start_px[m][0], sample[m].y_px - setup->mark.start_px[m][1]);
    if (!(sample[m].flags & TL_MARKER_SEEN) || moved > setup->mark.radius_px[m]) continue;
    setup->mark.start_px[m][0] = sample[m].x_px;
    setup->mark.start_px[m][1] = sample[m].y_px;
  }
}

static int set_lens(struct setup *setup, struct app_error *error) {
  char text[FACE_TEXT];
  const char *slash = strrchr(asked.out, '/');
  char beside[1200];
  if (!asked.lens) return 0;
  snprintf(beside, sizeof beside, "%.*s%.500s",
           slash && asked.lens[0] != '/' ? (int)(slash - asked.out + 1) : 0, asked.out, asked.lens);
  if (face_lens_read(beside, &setup->lens, text) != 0)
    return app_fail(error, APP_BAD_INPUT, "%s: %s", beside, text);
  snprintf(setup->lens_path, sizeof setup->lens_path, "%.500s", asked.lens);
  setup->view.focal_px = setup->lens.focal_px[0];
  setup->view.center_px[0] = setup->lens.center_px[0];
  setup->view.center_px[1] = setup->lens.center_px[1];
  return 0;
}

static int set_view(struct setup *setup, struct app_error *error) {
  setup->view.clockwise = !asked.counterclockwise;
  setup->view.shank_length_m = asked.shank_m;
  setup->has_lamp = asked.lamp != NULL;
  if (asked.lamp && (numbers_of(asked.lamp, setup->lamp_px, 3) != 0 || !(setup->lamp_px[2] > 0.0)))
    return app_fail(error, APP_BAD_INPUT, "--lamp: expected X,Y,RADIUS");
  if (asked.shank_m < 0.0) return app_fail(error, APP_BAD_INPUT, "--shank-length: expected a number above 0");
  return set_lens(setup, error) != 0 ? -1 : set_plumb(setup, error);
}

/* ---- all of it ------------------------------------------------------------------- */

static int write_sheet(const struct face_picture *p, const struct setup *setup, struct app_error *error) {
  char text[FACE_TEXT];
  if (!asked.sheet) return 0;
  for (int m = 0; m < setup->mark.markers; m++) {
    const double *at = setup->mark.start_px[m];
    face_circle(p, at[0], at[1], setup->mark.radius_px[m] + 4.0, 0x30d158u);
    face_label(p, at[0] + setup->mark.radius_px[m] + 8.0, at[1], setup->name[m], 0xffffffu);
  }
  if (face_write_sheet(asked.sheet, p, 1, 1, text) == 0) return 0;
  return app_fail(error, APP_FAILED, "%s: %s", asked.sheet, text);
}

static int from_picture(const struct face_picture *p, struct app_error *error) {
  struct spot spot[TL_MARKER_MAX];
  tl_marker_color color[TL_MARKER_MAX];
  struct setup setup;
  memset(&setup, 0, sizeof setup);
  if (set_view(&setup, error) != 0) return -1;
  const int n = asked.points ? sample_points(p, &setup, spot, error) : find_leg(p, &setup, spot, error);
  if (n < 0) return -1;
  setup.mark.markers = n;
  colors_separate(spot, n);
  for (int m = 0; m < n; m++) color[m] = spot[m].color;
  setup_complete(&setup, color);
  if (n == 4 && !setup.is_leg)
    app_note("without --shank-length and the names knee, ankle, heel, toe there will be no angles");
  refine(p, &setup);
  if (setup.is_leg && set_pose(&setup, error) != 0) return -1;
  if (write_sheet(p, &setup, error) != 0) return -1;
  return setup_write(asked.out, &setup, error);
}

static int calibrate(const char *path, struct app_error *error) {
  struct face_picture picture;
  char text[FACE_TEXT] = "no picture at that time";
  struct face_video *video = face_video_open(path, text);
  if (!video) return app_fail(error, APP_BAD_INPUT, "%s: %s", path, text);
  int more = face_video_next(video, &picture, text);
  while (more == 1 && picture.t_s < asked.at_s) more = face_video_next(video, &picture, text);
  const int result =
      more == 1 ? from_picture(&picture, error) : app_fail(error, APP_BAD_INPUT, "%s: %s", path, text);
  face_video_close(video);
  return result;
}

int command_calibrate(int argc, char **argv) {
  struct app_error error;
  int first;
  switch (cli_parse(&program, argc, argv, &first)) {
  case CLI_RUN: break;
  case CLI_DONE: return APP_OK;
  case CLI_USAGE: return APP_BAD_INPUT;
  }
  return calibrate(argv[first], &error) == 0 ? APP_OK : app_exit(&error);
}
