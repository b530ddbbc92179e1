/* recording.c: a recording prepared for diagnosis; see talus/gap.h. */
#include <math.h>
#include <string.h>

#include "talus/gap.h"

/* number of usable segments, and of grid instants in all */
static size_t count_segments(const tl_block *b, const uint8_t *valid, double step_s, size_t *grid) {
  size_t cursor = 0, count = 0;
  tl_segment part;

  *grid = 0;
  while (tl_segment_next(b->t_s, valid, b->n, step_s, &cursor, &part)) {
    *grid += tl_grid_count(b->t_s[part.begin], b->t_s[part.end - 1], step_s);
    count++;
  }
  return count;
}

/* doubles from the arena, cleared */
static double *take(tl_arena *arena, size_t n) {
  double *x = tl_arena_take(arena, n * sizeof *x);

  if (x) memset(x, 0, n * sizeof *x);
  return x;
}

static tl_status take_joint(tl_gap_recording *r, int j, tl_arena *arena) {
  r->columns[j] = tl_row_index(&r->regression.model, j, r->index[j]);
  r->q[j] = take(arena, r->n);
  r->v[j] = take(arena, r->n);
  r->a[j] = take(arena, r->n);
  r->slip[j] = take(arena, r->n);
  r->stop[j] = tl_arena_take(arena, r->n * sizeof(tl_stop));
  r->kind[j] = tl_arena_take(arena, r->m);
  r->x[j] = take(arena, (size_t)r->columns[j] * r->m);
  r->target[j] = take(arena, r->m);
  r->measured[j] = take(arena, r->m);
  r->stops[j] = 0;
  return r->q[j] && r->v[j] && r->a[j] && r->slip[j] && r->stop[j] && r->kind[j] && r->x[j] && r->target[j] &&
                 r->measured[j]
             ? TL_OK
             : TL_ERR_WORKSPACE;
}

static tl_status take_all(tl_gap_recording *r, const tl_block *b, const uint8_t *valid, tl_arena *arena) {
  int j;

  r->n = b->n;
  r->t_s = b->t_s;
  memcpy(r->channel, b->channel, sizeof r->channel);
  r->segments = count_segments(b, valid, r->regression.step_s, &r->m);
  if (r->segments == 0) return TL_ERR_TOO_SHORT;
  r->segment = tl_arena_take(arena, r->segments * sizeof *r->segment);
  r->grid_begin = tl_arena_take(arena, (r->segments + 1) * sizeof *r->grid_begin);
  r->grid_s = take(arena, r->m);
  if (!r->segment || !r->grid_begin || !r->grid_s) return TL_ERR_WORKSPACE;
  for (j = 0; j < tl_joint_count(&r->regression.model); j++) {
    tl_status status = take_joint(r, j, arena);
    if (status != TL_OK) return status;
  }
  return TL_OK;
}

/* motion and stops of one segment to their places in the recording */
static void keep_motion(tl_gap_recording *r, const tl_regression_space *space, tl_segment part, int j) {
  const tl_track *track = &space->track;
  size_t bytes = (part.end - part.begin) * sizeof(double), k;

  memcpy(r->q[j] + part.begin, track->q[j], bytes);
  memcpy(r->v[j] + part.begin, track->v[j], bytes);
  memcpy(r->a[j] + part.begin, track->a[j], bytes);
  memcpy(r->slip[j] + part.begin, track->slip[j], bytes);
  for (k = 0; k < track->stops[j]; k++) {
    tl_stop s = track->stop[j][k];
    if (s.before == TL_NO_ROW || s.after == TL_NO_ROW) continue;
    s.before += part.begin;
    s.after += part.begin;
    if (r->t_s[s.after] - r->t_s[s.before] <= TL_BRIDGE_S) r->stop[j][r->stops[j]++] = s;
  }
}

static void keep_rows(tl_gap_recording *r, const tl_rows *rows, size_t at, int j) {
  size_t bytes = rows->n * sizeof(double);
  int c;

  for (c = 0; c < rows->columns; c++)
    memcpy(r->x[j] + (size_t)c * r->m + at, rows->x + (size_t)c * rows->stride, bytes);
  memcpy(r->target[j] + at, rows->x + (size_t)rows->columns * rows->stride, bytes);
  memcpy(r->measured[j] + at, rows->x + (size_t)(rows->columns + 1) * rows->stride, bytes);
  memcpy(r->kind[j] + at, rows->kind, rows->n);
}

/* one segment through the regression, its memory given back afterwards */
static tl_status prepare_segment(tl_gap_recording *r, size_t i, tl_arena arena) {
  tl_segment part = r->segment[i];
  size_t rows = part.end - part.begin, grid = r->grid_begin[i + 1] - r->grid_begin[i] + 1, k;
  size_t joints = (size_t)tl_joint_count(&r->regression.model);
  double *memory = tl_arena_take(&arena, tl_regression_memory(&r->regression, rows, grid) * sizeof *memory);
  tl_stop *stops = tl_arena_take(&arena, joints * rows * sizeof *stops);
  uint8_t *mask = tl_arena_take(&arena, joints * grid);
  double first_s = r->t_s[part.begin], last_s = r->t_s[part.end - 1];
  tl_span span = {first_s, last_s, first_s, HUGE_VAL};
  tl_regression_space space;
  tl_block block;
  tl_status status;
  int c, j;

  if (!memory || !stops || !mask) return TL_ERR_WORKSPACE;
  tl_regression_space_init(&space, &r->regression, rows, grid, memory, stops, mask);
  block.n = rows;
  block.t_s = r->t_s + part.begin;
  for (c = 0; c < TL_CHANNEL_COUNT; c++) block.channel[c] = r->channel[c] ? r->channel[c] + part.begin : NULL;
  status = tl_regression_block(&r->regression, &block, &span, &space);
  if (status != TL_OK) return status;
  for (j = 0; j < (int)joints; j++) {
    keep_motion(r, &space, part, j);
    keep_rows(r, &space.rows[j], r->grid_begin[i], j);
  }
  for (k = r->grid_begin[i]; k < r->grid_begin[i + 1]; k++)
    r->grid_s[k] = first_s + (double)(k - r->grid_begin[i]) * r->regression.step_s;
  return TL_OK;
}

tl_status tl_gap_prepare(tl_gap_recording *r, const tl_regression *regression, const tl_block *columns,
                         const uint8_t *valid, tl_arena *arena) {
  size_t cursor = 0, i, step;
  tl_status status;

  if (!r || !regression || !columns || !arena) return TL_ERR_ARGUMENT;
  memset(r, 0, sizeof *r);
  r->regression = *regression;
  status = take_all(r, columns, valid, arena);
  if (status != TL_OK) return status;
  r->grid_begin[0] = 0;
  for (i = 0; i < r->segments; i++) {
    (void)tl_segment_next(r->t_s, valid, r->n, regression->step_s, &cursor, &r->segment[i]);
    step = tl_grid_count(r->t_s[r->segment[i].begin], r->t_s[r->segment[i].end - 1], regression->step_s);
    r->grid_begin[i + 1] = r->grid_begin[i] + step;
  }
  for (i = 0; i < r->segments && status == TL_OK; i++) status = prepare_segment(r, i, *arena);
  return status;
}

/* ---- the operator ---------------------------------------------------------------- */

void tl_gap_bridge(const tl_gap_recording *r, int joint, double *at_rows) {
  size_t k;

  for (k = 0; k < r->stops[joint]; k++) tl_bridge_stop(&r->stop[joint][k], r->t_s, at_rows);
}

void tl_gap_resample(const tl_gap_recording *r, const double *at_rows, double *on_grid) {
  size_t i;

  for (i = 0; i < r->segments; i++) {
    tl_segment part = r->segment[i];
    tl_grid_resample(r->t_s + part.begin, at_rows + part.begin, part.end - part.begin, r->t_s[part.begin],
                     r->regression.step_s, on_grid + r->grid_begin[i],
                     r->grid_begin[i + 1] - r->grid_begin[i]);
  }
}

void tl_gap_lowpass(const tl_gap_recording *r, double *on_grid) {
  size_t i;

  for (i = 0; i < r->segments; i++)
    tl_lowpass_zero_phase(&r->regression.lowpass, on_grid + r->grid_begin[i],
                          r->grid_begin[i + 1] - r->grid_begin[i]);
}
