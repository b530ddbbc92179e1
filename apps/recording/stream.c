/* stream.c: see stream.h. */
#include "stream.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/workers.h"
#include "stream_block.h"

/* ---- sensing ---------------------------------------------------------------- */

static double travel(const double *x, size_t n) {
  double low = x[0], high = x[0];

  for (size_t i = 1; i < n; i++) {
    low = x[i] < low ? x[i] : low;
    high = x[i] > high ? x[i] : high;
  }
  return high - low;
}

/* the place where the joint moves most: a joint at rest shows neither noise nor resolution */
static int liveliest(const struct stream *s, struct stream_room *room, tl_channel angle, tl_segment *best,
                     struct app_error *error) {
  double most = -1.0;

  for (int k = 0; k < TL_SAMPLE_PLACES; k++) {
    tl_segment place = tl_sample_place(s->segments.segment, s->segments.count, k);
    double here;

    if (place.end - place.begin < 30) continue;
    if (stream_room_load(room, s, place.begin, place.end, error) != 0) return -1;
    here = travel(room->column[angle], place.end - place.begin);
    if (here <= most) continue;
    most = here;
    *best = place;
  }
  if (most < 0.0)
    return app_fail(error, APP_BAD_INPUT, "%s: no run of at least 30 valid rows without a gap",
                    recording_path(s->recording));
  return 0;
}

static int sense_joint(struct stream *s, struct stream_room *room, int joint, const tl_window *window,
                       struct app_error *error) {
  tl_regression *r = &s->regression;
  tl_channel angle =
      r->layout.position[joint] != TL_CHANNEL_COUNT ? r->layout.position[joint] : r->layout.velocity[joint];
  size_t work_n = tl_kinematics_window_workspace(TL_SAMPLE_ROWS);
  double *work = malloc(work_n * sizeof *work);
  tl_segment place = {0, 0};
  tl_block block;
  tl_status status = TL_OK;
  int result = work ? 0 : app_fail(error, APP_FAILED, "out of memory");

  if (result == 0) result = liveliest(s, room, angle, &place, error);
  if (result == 0) result = stream_room_load(room, s, place.begin, place.end, error);
  if (result == 0) {
    block = stream_room_block(room, 0, place.end - place.begin);
    status = tl_kinematics_window(&r->model, &r->layout, joint, &r->score, r->step_s, &block, work, work_n,
                                  &r->sensing[joint]);
  }
  free(work);
  if (result == 0 && status != TL_OK)
    result = app_fail(error, APP_FAILED, "%s: %s", recording_path(s->recording), tl_status_text(status));
  if (window) {
    r->sensing[joint].window = *window;
    r->sensing[joint].across = 1;
  }
  return result;
}

static int sense(struct stream *s, const tl_window *window, struct app_error *error) {
  struct stream_room room = {0};
  int result = 0;

  for (int j = 0; j < tl_joint_count(&s->regression.model) && result == 0; j++)
    result = sense_joint(s, &room, j, window, error);
  for (int j = 0; j < TL_MAX_JOINTS; j++) s->window_s[j] = s->regression.sensing[j].window.length_s;
  stream_room_free(&room);
  return result;
}

/* ---- opening ---------------------------------------------------------------- */

static uint32_t recorded_channels(const struct recording *recording) {
  uint32_t set = 0;

  for (int c = 0; c < TL_CHANNEL_COUNT; c++)
    if (recording_has(recording, (tl_channel)c)) set |= TL_CHANNEL_BIT(c);
  return set;
}

static int find_segments(struct stream *s, struct app_error *error) {
  if (segments_find(s->recording, &s->segments, error) != 0) return -1;
  if (s->segments.count > 0) return 0;
  return app_fail(error, APP_BAD_INPUT, "%s: no run of more than 20 valid rows without a gap",
                  recording_path(s->recording));
}

static int stream_prepare(struct stream *s, const tl_model *model, const tl_score_settings *score,
                          const tl_window *window, struct app_error *error) {
  tl_status status = tl_regression_init(&s->regression, model, recorded_channels(s->recording), score,
                                        recording_step_s(s->recording));

  if (status != TL_OK)
    return app_fail(error, APP_BAD_INPUT, "%s: %s", recording_path(s->recording), tl_status_text(status));
  if (find_segments(s, error) != 0) return -1;
  return sense(s, window, error);
}

struct stream *stream_open(struct recording *recording, const tl_model *model, const tl_score_settings *score,
                           const tl_window *window, struct app_error *error) {
  struct stream *s = calloc(1, sizeof *s);

  if (!s) {
    app_fail(error, APP_FAILED, "out of memory");
    return NULL;
  }
  s->recording = recording;
  s->workers = workers_processors();
  s->rounding = -1;
  s->task = "computing";
  if (stream_prepare(s, model, score, window, error) == 0) return s;
  stream_close(s);
  return NULL;
}

struct stream *stream_open_as(const struct stream *whole, struct recording *excerpt,
                              struct app_error *error) {
  struct stream *s = malloc(sizeof *s);

  if (!s) {
    app_fail(error, APP_FAILED, "out of memory");
    return NULL;
  }
  *s = *whole;
  s->recording = excerpt;
  if (find_segments(s, error) == 0) return s;
  stream_close(s);
  return NULL;
}

void stream_close(struct stream *stream) {
  if (!stream) return;
  segments_free(&stream->segments);
  free(stream);
}

int stream_set_effects(struct stream *stream, const tl_effect *effect, int effects, struct app_error *error) {
  tl_status status =
      tl_regression_set_effects(&stream->regression, effect, effects, recording_first_s(stream->recording));

  if (status == TL_OK) return 0;
  if (status == TL_ERR_UNSUPPORTED)
    return app_fail(error, APP_BAD_INPUT,
                    "%s: the temperature that an effect of the model needs is not there",
                    recording_path(stream->recording));
  return app_fail(error, APP_BAD_INPUT,
                  "effects: the linkage does not close with the errors of linkage_error");
}

const tl_regression *stream_regression(const struct stream *stream) {
  return &stream->regression;
}

const char *stream_path(const struct stream *stream) {
  return recording_path(stream->recording);
}

void stream_set_workers(struct stream *stream, int workers) {
  stream->workers = workers < 1 ? 1 : workers > WORKERS_MOST ? WORKERS_MOST : workers;
}

void stream_set_task(struct stream *stream, const char *task) {
  stream->task = task;
}

void stream_reread(struct stream *stream, double window_factor, int rounding) {
  for (int j = 0; j < TL_MAX_JOINTS; j++)
    stream->regression.sensing[j].window.length_s = window_factor * stream->window_s[j];
  stream->rounding = rounding;
}
