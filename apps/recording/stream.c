/* stream.c: see stream.h. */
#include "stream.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "segments.h"

#define PART_ROWS 4096 /* rows that are a block's own */
#define LEAST_ROWS 64  /* a block is not smaller, where the segment allows */
#define SAMPLES 8      /* places of a recording that its sensing may be measured at */
#define SAMPLE_ROWS 4096

struct stream {
  struct recording *recording;
  struct segments segments;
  tl_regression regression;
  tl_regression_space space;
  /* memory, grown as blocks need it */
  size_t rows, grid;
  double *columns; /* TL_CHANNEL_COUNT arrays of `rows` */
  double *memory;
  tl_stop *stops;
  uint8_t *mask;
  double *column[TL_CHANNEL_COUNT];
};

/* ---- memory ---------------------------------------------------------------- */

/* which channels the regression reads */
static void used_channels(const tl_regression *r, int joints, int used[TL_CHANNEL_COUNT]) {
  const tl_layout *l = &r->layout;
  memset(used, 0, TL_CHANNEL_COUNT * sizeof *used);
  used[TL_CHANNEL_TIME] = 1;
  for (int j = 0; j < joints; j++) {
    tl_channel angle = l->position[j] != TL_CHANNEL_COUNT ? l->position[j] : l->velocity[j];
    used[angle] = used[l->effort[j]] = 1;
    if (r->temperature[j] != TL_CHANNEL_COUNT) used[r->temperature[j]] = 1;
  }
  if (l->load != TL_CHANNEL_COUNT) used[l->load] = 1;
}

static int make_room(struct stream *s, size_t rows, size_t grid, struct app_error *error) {
  int joints = tl_joint_count(&s->regression.model), used[TL_CHANNEL_COUNT];
  double *at;

  if (rows <= s->rows && grid <= s->grid) return 0;
  s->rows = rows > s->rows ? rows : s->rows;
  s->grid = grid > s->grid ? grid : s->grid;
  free(s->columns);
  free(s->memory);
  free(s->stops);
  free(s->mask);
  s->columns = malloc(TL_CHANNEL_COUNT * s->rows * sizeof(double));
  s->memory = malloc(tl_regression_memory(&s->regression, s->rows, s->grid) * sizeof(double));
  s->stops = malloc((size_t)joints * s->rows * sizeof(tl_stop));
  s->mask = malloc((size_t)joints * s->grid);
  if (!s->columns || !s->memory || !s->stops || !s->mask)
    return app_fail(error, APP_FAILED, "out of memory for a block of %zu rows", s->rows);
  tl_regression_space_init(&s->space, &s->regression, s->rows, s->grid, s->memory, s->stops, s->mask);
  used_channels(&s->regression, joints, used);
  at = s->columns;
  for (int c = 0; c < TL_CHANNEL_COUNT; c++) {
    s->column[c] = used[c] ? at : NULL;
    if (used[c]) at += s->rows;
  }
  return 0;
}

/* rows [from, to) into the stream's columns, as a block */
static int load(struct stream *s, size_t from, size_t to, tl_block *block, struct app_error *error) {
  if (make_room(s, to - from, s->grid, error) != 0) return -1;
  if (recording_read(s->recording, from, to - from, s->column, NULL, error) != 0) return -1;
  block->n = to - from;
  block->t_s = s->column[TL_CHANNEL_TIME];
  for (int c = 0; c < TL_CHANNEL_COUNT; c++) block->channel[c] = s->column[c];
  return 0;
}

/* ---- sensing ---------------------------------------------------------------- */

/* rows of the k-th place to look at, spread over the usable rows */
static tl_segment sample_place(const struct segments *all, int k) {
  size_t total = 0, i, at;

  for (i = 0; i < all->count; i++) total += all->segment[i].end - all->segment[i].begin;
  at = total / SAMPLES * (size_t)k;
  for (i = 0; i + 1 < all->count && at >= all->segment[i].end - all->segment[i].begin; i++)
    at -= all->segment[i].end - all->segment[i].begin;
  at += all->segment[i].begin;
  if (at + SAMPLE_ROWS > all->segment[i].end)
    at = all->segment[i].end - all->segment[i].begin > SAMPLE_ROWS ? all->segment[i].end - SAMPLE_ROWS
                                                                   : all->segment[i].begin;
  return (tl_segment){at, at + SAMPLE_ROWS < all->segment[i].end ? at + SAMPLE_ROWS : all->segment[i].end};
}

static double travel(const double *x, size_t n) {
  double low = x[0], high = x[0];

  for (size_t i = 1; i < n; i++) {
    low = x[i] < low ? x[i] : low;
    high = x[i] > high ? x[i] : high;
  }
  return high - low;
}

/* the place where the joint moves most: a joint at rest shows neither noise nor resolution */
static int liveliest(struct stream *s, const double *const *x, tl_segment *best, struct app_error *error) {
  double most = -1.0;

  for (int k = 0; k < SAMPLES; k++) {
    tl_segment place = sample_place(&s->segments, k);
    tl_block block;
    double here;

    if (place.end - place.begin < 30) continue;
    if (load(s, place.begin, place.end, &block, error) != 0) return -1;
    here = travel(*x, block.n);
    if (here <= most) continue;
    most = here;
    *best = place;
  }
  if (most < 0.0)
    return app_fail(error, APP_BAD_INPUT, "%s: no run of at least 30 valid rows without a gap",
                    recording_path(s->recording));
  return 0;
}

static int sense_joint(struct stream *s, int joint, const tl_window *window, struct app_error *error) {
  tl_regression *r = &s->regression;
  tl_channel angle =
      r->layout.position[joint] != TL_CHANNEL_COUNT ? r->layout.position[joint] : r->layout.velocity[joint];
  size_t work_n = tl_kinematics_window_workspace(SAMPLE_ROWS);
  double *work = malloc(work_n * sizeof *work);
  tl_segment place = {0, 0};
  tl_block block;
  tl_status status = TL_OK;
  int result = work ? 0 : app_fail(error, APP_FAILED, "out of memory");

  if (result == 0) result = liveliest(s, (const double *const *)&s->column[angle], &place, error);
  if (result == 0) result = load(s, place.begin, place.end, &block, error);
  if (result == 0)
    status = tl_kinematics_window(&r->model, &r->layout, joint, &r->score, r->step_s, &block, work, work_n,
                                  &r->sensing[joint]);
  free(work);
  if (result == 0 && status != TL_OK)
    result = app_fail(error, APP_FAILED, "%s: %s", recording_path(s->recording), tl_status_text(status));
  if (window) {
    r->sensing[joint].window = *window;
    r->sensing[joint].across = 1;
  }
  return result;
}

/* ---- opening ---------------------------------------------------------------- */

static uint32_t recorded_channels(const struct recording *recording) {
  uint32_t set = 0;

  for (int c = 0; c < TL_CHANNEL_COUNT; c++)
    if (recording_has(recording, (tl_channel)c)) set |= TL_CHANNEL_BIT(c);
  return set;
}

static int stream_prepare(struct stream *s, const tl_model *model, const tl_score_settings *score,
                          const tl_window *window, struct app_error *error) {
  tl_status status = tl_regression_init(&s->regression, model, recorded_channels(s->recording), score,
                                        recording_step_s(s->recording));

  if (status != TL_OK)
    return app_fail(error, APP_BAD_INPUT, "%s: %s", recording_path(s->recording), tl_status_text(status));
  if (segments_find(s->recording, &s->segments, error) != 0) return -1;
  if (s->segments.count == 0)
    return app_fail(error, APP_BAD_INPUT, "%s: no run of more than 20 valid rows without a gap",
                    recording_path(s->recording));
  if (make_room(s, SAMPLE_ROWS, 1, error) != 0) return -1;
  for (int j = 0; j < tl_joint_count(model); j++)
    if (sense_joint(s, j, window, error) != 0) return -1;
  return 0;
}

struct stream *stream_open(struct recording *recording, const tl_model *model, const tl_score_settings *score,
                           const tl_window *window, struct app_error *error) {
  struct stream *s = calloc(1, sizeof *s);

  if (!s) {
    app_fail(error, APP_FAILED, "out of memory");
    return NULL;
  }
  s->recording = recording;
  if (stream_prepare(s, model, score, window, error) == 0) return s;
  stream_close(s);
  return NULL;
}

void stream_close(struct stream *stream) {
  if (!stream) return;
  segments_free(&stream->segments);
  free(stream->columns);
  free(stream->memory);
  free(stream->stops);
  free(stream->mask);
  free(stream);
}

int stream_set_effects(struct stream *stream, const tl_effect *effect, int effects, struct app_error *error) {
  tl_status status =
      tl_regression_set_effects(&stream->regression, effect, effects, recording_first_s(stream->recording));

  if (status == TL_OK) {
    stream->rows = 0; /* other columns may be wanted now: room is made anew */
    return 0;
  }
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

/* ---- walking ---------------------------------------------------------------- */

static int time_at(struct stream *s, size_t row, double *t_s, struct app_error *error) {
  double *column[TL_CHANNEL_COUNT] = {NULL};

  column[TL_CHANNEL_TIME] = t_s;
  return recording_read(s->recording, row, 1, column, NULL, error);
}

/* the first row in [low, high] whose time is not below at_s; high when none is */
static int row_at(struct stream *s, size_t low, size_t high, double at_s, size_t *row,
                  struct app_error *error) {
  while (low < high) {
    size_t middle = low + (high - low) / 2;
    double t_s;
    if (time_at(s, middle, &t_s, error) != 0) return -1;
    if (t_s < at_s)
      low = middle + 1;
    else
      high = middle;
  }
  *row = low;
  return 0;
}

/* rows around the part's own that the block must see */
static int surround(struct stream *s, tl_segment segment, struct stream_part *part, size_t *from, size_t *to,
                    struct app_error *error) {
  double margin_s = tl_regression_margin_s(&s->regression), begin_s, end_s;

  if (time_at(s, part->begin, &begin_s, error) != 0 || time_at(s, part->end - 1, &end_s, error) != 0)
    return -1;
  if (row_at(s, segment.begin, part->begin, begin_s - margin_s, from, error) != 0) return -1;
  if (row_at(s, part->end, segment.end, end_s + margin_s, to, error) != 0) return -1;
  if (*to - *from < LEAST_ROWS) *from = *to > segment.begin + LEAST_ROWS ? *to - LEAST_ROWS : segment.begin;
  return 0;
}

/* where the block lies in its segment, for the grid */
static int make_span(struct stream *s, tl_segment segment, const struct stream_part *part, tl_span *span,
                     struct app_error *error) {
  if (time_at(s, segment.begin, &span->segment_begin_s, error) != 0) return -1;
  if (time_at(s, segment.end - 1, &span->segment_end_s, error) != 0) return -1;
  if (time_at(s, part->begin, &span->begin_s, error) != 0) return -1;
  span->end_s = HUGE_VAL;
  return part->end < segment.end ? time_at(s, part->end, &span->end_s, error) : 0;
}

/* room for the block's rows, and for its grid where rows are wanted */
static int room_for(struct stream *s, size_t from, size_t to, int with_rows, struct app_error *error) {
  double first_s, last_s;
  size_t grid = 1;

  if (with_rows) {
    if (time_at(s, from, &first_s, error) != 0 || time_at(s, to - 1, &last_s, error) != 0) return -1;
    grid = (size_t)((last_s - first_s) / s->regression.step_s) + 3;
  }
  return make_room(s, to - from, grid, error);
}

/* one part: load its block, compute, let the visitor see it */
static int walk_part(struct stream *s, tl_segment segment, struct stream_part *part, int with_rows,
                     stream_visit visit, void *context, struct app_error *error) {
  size_t to;
  tl_block block;
  tl_span span;
  tl_status status;

  if (surround(s, segment, part, &part->first, &to, error) != 0) return -1;
  if (make_span(s, segment, part, &span, error) != 0) return -1;
  if (room_for(s, part->first, to, with_rows, error) != 0) return -1;
  if (load(s, part->first, to, &block, error) != 0) return -1;
  status = with_rows ? tl_regression_block(&s->regression, &block, &span, &s->space)
                     : tl_regression_motion(&s->regression, &block, &s->space);
  if (status != TL_OK)
    return app_fail(error, APP_FAILED, "%s: rows %zu to %zu: %s", recording_path(s->recording), part->begin,
                    part->end, tl_status_text(status));
  part->t_s = block.t_s;
  return visit(part, context, error);
}

static int walk(struct stream *s, int with_rows, stream_visit visit, void *context, struct app_error *error) {
  for (size_t i = 0; i < s->segments.count; i++) {
    tl_segment segment = s->segments.segment[i];

    for (size_t row = segment.begin; row < segment.end; row += PART_ROWS) {
      struct stream_part part = {&s->regression,       &s->space, 0, row, row + PART_ROWS,
                                 row == segment.begin, NULL};
      int result;

      if (part.end > segment.end) part.end = segment.end;
      result = walk_part(s, segment, &part, with_rows, visit, context, error);
      if (result != 0) return result;
    }
  }
  return 0;
}

int stream_rows(struct stream *stream, stream_visit visit, void *context, struct app_error *error) {
  return walk(stream, 1, visit, context, error);
}

int stream_motion(struct stream *stream, stream_visit visit, void *context, struct app_error *error) {
  return walk(stream, 0, visit, context, error);
}
