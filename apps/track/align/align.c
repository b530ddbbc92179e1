/* align.c: talus-track align: a track and a recording of the same motion on one clock, and merged. */
#include "track/align/align.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/cli.h"
#include "common/json_file.h"
#include "recording/recording.h"
#include "track/align/export_report.h"
#include "track/align/merge.h"
#include "track/commands.h"
#include "track/table.h"

static struct {
  const char *recording, *out, *report, *flashes, *export;
  double exposure_s, near_s;
} asked = {.near_s = 1e300};

static const struct cli_option options[] = {
    {"recording", 'r', CLI_TEXT, &asked.recording, 1, "REC.csv", "the leg's recording of the same motion"},
    {"out", 'o', CLI_TEXT, &asked.out, 1, "MERGED.csv",
     "the recording with shank_rad and foot_rad, as far as the film goes"},
    {"report", 0, CLI_TEXT, &asked.report, 0, "R.json", "offset, rate, their uncertainty, residuals"},
    {"near", 0, CLI_NUMBER, &asked.near_s, 0, "S",
     "the recording's time less the camera's, to a second (a motion that repeats needs it)"},
    {"export", 0, CLI_TEXT, &asked.export, 0, "E.json",
     "the recording's report by talus-acquire-export: a camera that the kernel stamps needs no --near"},
    {"flashes", 0, CLI_TEXT, &asked.flashes, 0, "F.csv",
     "edges of the sync lamp on the recording's clock: time_s, on (1 or 0)"},
    {"exposure", 0, CLI_NUMBER, &asked.exposure_s, 0, "S",
     "of a picture, for the flashes (default: unknown)"},
};

static const struct cli_program program = {
    .name = "talus-track align",
    .summary =
        "finds offset and rate of the camera's clock against a recording, and merges the angles into it",
    .example = "talus-track align --recording walk.csv --out merged.csv --report align.json track.csv",
    .arguments = "TRACK.csv",
    .min_arguments = 1,
    .max_arguments = 1,
    .option = options,
    .options = sizeof options / sizeof options[0],
};

enum { TIME, SHANK, SHANK_SIGMA, FOOT, FOOT_SIGMA, LAMP, TRACK_COLUMNS };
static const char *const track_names[TRACK_COLUMNS] = {"time_s",   "shank_rad",      "shank_sigma_rad",
                                                       "foot_rad", "foot_sigma_rad", "lamp"};

struct job {
  const char *path;
  struct table track, flashes;
  struct recording *recording;
  double *memory;            /* of the series below */
  struct series shank, foot; /* pictures in which the link is whole */
  double sigma_rad[2];
  struct align_data data;
  struct clock_fit clock, motion; /* the answer; what the motion alone says */
  struct merge_result merged;
};

/* ---- the series ------------------------------------------------------------------ */

/* `slots` series share the memory, each with room for times and values of all rows. */
static double *slot(struct job *job, int which) {
  const size_t rows = job->track.rows + recording_rows(job->recording);
  return job->memory + 2 * rows * (size_t)which;
}

static struct series whole_of(struct job *job, int column, int which, double *sigma_rad) {
  const struct table *t = &job->track;
  double *time = slot(job, which), *x = time + t->rows, sum = 0.0;
  size_t n = 0;
  for (size_t i = 0; i < t->rows; i++) {
    const double sigma = t->column[column + 1][i];
    if (!(sigma > 0.0)) continue;
    sum += sigma * sigma;
    time[n] = t->column[TIME][i];
    x[n++] = t->column[column][i];
  }
  *sigma_rad = n ? sqrt(sum / (double)n) : 0.0;
  return (struct series){n, time, x};
}

/* Foot less shank, where both are whole. */
static struct series ankle_of(struct job *job, int which) {
  const struct table *t = &job->track;
  double *time = slot(job, which), *x = time + t->rows;
  size_t n = 0;
  for (size_t i = 0; i < t->rows; i++) {
    if (!(t->column[SHANK_SIGMA][i] > 0.0 && t->column[FOOT_SIGMA][i] > 0.0)) continue;
    time[n] = t->column[TIME][i];
    x[n++] = t->column[FOOT][i] - t->column[SHANK][i];
  }
  return (struct series){n, time, x};
}

static int encoders(struct job *job, struct app_error *error) {
  const size_t n = recording_rows(job->recording);
  double *column[TL_CHANNEL_COUNT] = {NULL};
  double *time = slot(job, 3), *knee = slot(job, 4), *ankle = slot(job, 5);
  column[TL_CHANNEL_TIME] = time;
  column[TL_CHANNEL_KNEE_MOTOR] = knee;
  column[TL_CHANNEL_ANKLE_JOINT] = ankle;
  if (recording_read(job->recording, 0, n, column, NULL, error) != 0) return -1;
  job->data.encoder[0] = (struct series){n, time, knee};
  job->data.encoder[1] = (struct series){n, time, ankle};
  return 0;
}

static int load(struct job *job, struct app_error *error) {
  if (table_read(job->path, track_names, TRACK_COLUMNS, LAMP, &job->track, error) != 0) return -1;
  job->recording = recording_open(asked.recording, TL_PLANT_LEG, error);
  if (!job->recording) return -1;
  job->memory = malloc(12 * (job->track.rows + recording_rows(job->recording)) * sizeof(double));
  if (!job->memory) return app_fail(error, APP_FAILED, "out of memory");
  job->shank = whole_of(job, SHANK, 0, &job->sigma_rad[0]);
  job->foot = whole_of(job, FOOT, 1, &job->sigma_rad[1]);
  job->data.camera[0] = job->shank;
  job->data.camera[1] = ankle_of(job, 2);
  if (job->shank.n < 100 || job->foot.n < 100)
    return app_fail(error, APP_BAD_INPUT,
                    "%s: %zu pictures show the whole shank, %zu the foot, expected 100 of each", job->path,
                    job->shank.n, job->foot.n);
  return encoders(job, error);
}

/* ---- flashes ---------------------------------------------------------------------- */

static int by_flashes(struct job *job, struct app_error *error) {
  static const char *const names[] = {"time_s", "on"};
  if (!asked.flashes) return 0;
  if (!job->track.column[LAMP])
    return app_fail(error, APP_BAD_INPUT, "%s: missing column: lamp (the setup has no lamp)", job->path);
  if (table_read(asked.flashes, names, 2, 2, &job->flashes, error) != 0) return -1;
  if (job->flashes.rows < 2) return app_fail(error, APP_BAD_INPUT, "%s: fewer than 2 edges", asked.flashes);
  const struct flash_data data = {{job->track.rows, job->track.column[TIME], job->track.column[LAMP]},
                                  {job->flashes.rows, job->flashes.column[0], job->flashes.column[1]},
                                  asked.exposure_s};
  return align_flashes(&data, &job->clock, error);
}

/* ---- what is said ------------------------------------------------------------------- */

static void set_clock(json_t *root, const struct clock_fit *c) {
  json_set_number(root, "offset_s", c->middle_rec_s - c->middle_cam_s);
  json_set_number(root, "offset_sigma_s", c->offset_sigma_s);
  json_set_number(root, "at_camera_s", c->middle_cam_s);
  json_set_number(root, "rate_ppm", 1e6 * c->rate);
  json_set_number(root, "rate_sigma_ppm", 1e6 * c->rate_sigma);
}

static json_t *joint_json(const struct job *job, int joint) {
  json_t *one = json_object();
  json_set_number(one, "gain", job->motion.gain[joint]);
  json_set_number(one, "constant_rad", job->motion.constant[joint]);
  json_set_number(one, "residual_rad", job->motion.residual_rad[joint]);
  json_object_set_new(one, "samples", json_integer((json_int_t)job->motion.samples[joint]));
  return one;
}

static int write_report(const struct job *job, struct app_error *error) {
  json_t *root = json_object(), *motion = json_object(), *merged = json_object();
  json_set_text(root, "schema", "talus-track-align/1");
  json_set_text(root, "method", asked.flashes ? "flashes" : "motion");
  set_clock(root, &job->clock);
  set_clock(motion, &job->motion);
  json_set_number(motion, "correlation", job->motion.correlation);
  json_object_set_new(motion, "shank", joint_json(job, 0));
  json_object_set_new(motion, "ankle", joint_json(job, 1));
  json_object_set_new(root, "motion", motion);
  json_object_set_new(merged, "rows", json_integer((json_int_t)job->merged.rows));
  json_object_set_new(merged, "outside_the_film", json_integer((json_int_t)job->merged.outside));
  json_object_set_new(merged, "not_seen", json_integer((json_int_t)job->merged.unseen));
  json_set_number(merged, "shank_interpolation_rad", job->merged.interpolation_rad[0]);
  json_set_number(merged, "foot_interpolation_rad", job->merged.interpolation_rad[1]);
  json_set_number(merged, "shank_sigma_rad", job->sigma_rad[0]);
  json_set_number(merged, "foot_sigma_rad", job->sigma_rad[1]);
  json_object_set_new(root, "merged", merged);
  const int result = asked.report ? json_file_write(asked.report, root, error) : 0;
  json_decref(root);
  return result;
}

static void print_result(const struct job *job) {
  const struct clock_fit *c = &job->clock;
  fprintf(stderr,
          "camera's time + %.6f s (+- %.3f ms) is the recording's, at %.3f s of the film; rate %+.2f ppm (+- "
          "%.2f), by %s\n",
          c->middle_rec_s - c->middle_cam_s, 1e3 * c->offset_sigma_s, c->middle_cam_s, 1e6 * c->rate,
          1e6 * c->rate_sigma, asked.flashes ? "flashes" : "motion");
  fprintf(stderr, "velocities correlate by %.4f; residual %.3f (shank), %.3f mrad (ankle)\n",
          job->motion.correlation, 1e3 * job->motion.residual_rad[0], 1e3 * job->motion.residual_rad[1]);
  fprintf(stderr,
          "%zu samples written, %zu lie outside the film, %zu have valid = 0 because a marker was not seen; "
          "interpolation "
          "adds %.4f (shank), %.4f mrad (foot)\n",
          job->merged.rows, job->merged.outside, job->merged.unseen, 1e3 * job->merged.interpolation_rad[0],
          1e3 * job->merged.interpolation_rad[1]);
}

/* Flashes and motion must not contradict each other: what is off says which to look at. */
static void note_difference(const struct job *job) {
  const double apart = job->clock.middle_rec_s - clock_to_rec(&job->motion, job->clock.middle_cam_s);
  const double sigma = hypot(job->clock.offset_sigma_s, job->motion.offset_sigma_s);
  if (asked.flashes && fabs(apart) > 4.0 * sigma)
    app_note("flashes and motion differ by %.3f ms, %.0f times their uncertainty: a joint that yields, or "
             "edges of another clock",
             1e3 * apart, fabs(apart) / sigma);
}

static int align(struct job *job, struct app_error *error) {
  const struct series angle[2] = {job->shank, job->foot};
  if (asked.export && export_report_offset(asked.export, &asked.near_s, error) != 0) return -1;
  if (align_coarse(&job->data, asked.near_s < 1e299 ? &asked.near_s : NULL, &job->clock, error) != 0)
    return -1;
  if (align_fine(&job->data, &job->clock, error) != 0) return -1;
  job->motion = job->clock;
  if (by_flashes(job, error) != 0) return -1;
  if (job->motion.gain[0] < 0.0)
    app_note("the camera's shank turns against the knee's motor: is the setup's 'positive' the right sense?");
  if (merge_write(asked.out, job->recording, angle, &job->clock, &job->merged, error) != 0) return -1;
  for (int k = 0; k < 2; k++)
    job->merged.interpolation_rad[k] = merge_interpolation(&angle[k], job->sigma_rad[k]);
  if (write_report(job, error) != 0) return -1;
  note_difference(job);
  print_result(job);
  return 0;
}

int command_align(int argc, char **argv) {
  struct app_error error;
  struct job job;
  int first;
  memset(&job, 0, sizeof job);
  switch (cli_parse(&program, argc, argv, &first)) {
  case CLI_RUN: break;
  case CLI_DONE: return APP_OK;
  case CLI_USAGE: return APP_BAD_INPUT;
  }
  job.path = argv[first];
  if (asked.exposure_s < 0.0) {
    cli_complain("--exposure: expected a number above 0");
    return APP_BAD_INPUT;
  }
  if (asked.export && asked.near_s < 1e299) {
    cli_complain("--near and --export both say where the clocks lie");
    return APP_BAD_INPUT;
  }
  int result = load(&job, &error);
  if (result == 0) result = align(&job, &error);
  table_free(&job.track);
  table_free(&job.flashes);
  recording_close(job.recording);
  free(job.memory);
  return result == 0 ? APP_OK : app_exit(&error);
}
