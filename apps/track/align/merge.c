/* merge.c: see merge.h. */
#include "track/align/merge.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "recording/recording_writer.h"

#define ROWS 4096
#define WIDEST 3.5 /* usual steps between two of the four pictures of an interpolation */
#define DECIMALS 9

/* the usual step: the least among groups of the mean, so that gaps do not count */
static double usual_step(const struct series *s) {
  double least = s->t_s[s->n - 1] - s->t_s[0];
  for (size_t i = 16; i < s->n; i += 16) {
    const double mean = (s->t_s[i] - s->t_s[i - 16]) / 16.0;
    if (mean < least) least = mean;
  }
  return least;
}

double merge_interpolation(const struct series *s, double sigma_rad) {
  const double widest = WIDEST * usual_step(s);
  double sum = 0.0;
  size_t n = 0;
  for (size_t i = 2; i + 2 < s->n; i++) {
    const double t[4] = {s->t_s[i - 2], s->t_s[i - 1], s->t_s[i + 1], s->t_s[i + 2]};
    const double x[4] = {s->x[i - 2], s->x[i - 1], s->x[i + 1], s->x[i + 2]};
    const struct series around = {4, t, x};
    double value, wide;
    if (series_cubic(&around, s->t_s[i], &value, NULL, &wide) != 0 || wide > widest) continue;
    sum += (value - s->x[i]) * (value - s->x[i]);
    n++;
  }
  /* the cubic's error goes with the product of the distances: 4 steps^4 here, 9/16 between two neighbours; noise of the
   * five pictures, with weights 1, 2/3, 1/6, enters with a variance of 1.944 */
  const double excess = n ? sum / (double)n - 1.944 * sigma_rad * sigma_rad : 0.0;
  return excess > 0.0 ? 9.0 / 64.0 * sqrt(excess) : 0.0;
}

/* 1 with the angle, 0 where no picture is near (the angle is then the nearest estimate), -1 outside the film. */
static int angle_at(const struct series *s, double cam_s, double widest_s, double *angle) {
  double wide;
  if (series_cubic(s, cam_s, angle, NULL, &wide) != 0) return -1;
  if (wide <= widest_s) return 1;
  size_t i = 0, high = s->n - 1; /* a line between the two pictures: a cubic would swing */
  while (high - i > 1) {
    const size_t middle = (i + high) / 2;
    if (s->t_s[middle] <= cam_s)
      i = middle;
    else
      high = middle;
  }
  *angle = s->x[i] + (s->x[i + 1] - s->x[i]) * (cam_s - s->t_s[i]) / (s->t_s[i + 1] - s->t_s[i]);
  return s->t_s[i + 1] - s->t_s[i] <= widest_s ? 1 : 0;
}

struct merging {
  struct recording *recording;
  const struct series *angle;
  const struct clock_fit *clock;
  struct merge_result *result;
  struct recording_writer *writer;
  double widest_s;
};

static void write_row(struct merging *m, double row[TL_CHANNEL_COUNT], int valid) {
  const double cam_s = clock_to_cam(m->clock, row[TL_CHANNEL_TIME]);
  double angle[2];
  int seen = 1;
  for (int k = 0; k < 2; k++) {
    const int here = angle_at(&m->angle[k], cam_s, m->widest_s, &angle[k]);
    if (here < seen) seen = here;
  }
  if (seen < 0) {
    m->result->outside++;
    return;
  }
  row[TL_CHANNEL_SHANK] = angle[0];
  row[TL_CHANNEL_FOOT] = angle[1];
  row[TL_CHANNEL_VALID] = valid && seen ? 1.0 : 0.0;
  m->result->unseen += (size_t)!seen;
  m->result->rows++;
  recording_writer_row(m->writer, row);
}

static int write_rows(struct merging *m, double *memory, uint8_t *valid, struct app_error *error) {
  const size_t all = recording_rows(m->recording);
  double *column[TL_CHANNEL_COUNT], row[TL_CHANNEL_COUNT];
  for (int c = 0; c < TL_CHANNEL_COUNT; c++) column[c] = memory + (size_t)c * ROWS;
  for (size_t from = 0; from < all; from += ROWS) {
    const size_t n = all - from < ROWS ? all - from : ROWS;
    if (recording_read(m->recording, from, n, column, valid, error) != 0) return -1;
    for (size_t i = 0; i < n; i++) {
      for (int c = 0; c < TL_CHANNEL_COUNT; c++) row[c] = column[c][i];
      write_row(m, row, valid[i]);
    }
  }
  if (m->result->rows < RECORDING_MIN_ROWS)
    return app_fail(error, APP_BAD_INPUT, "%s: only %zu samples lie within the film",
                    recording_path(m->recording), m->result->rows);
  return 0;
}

int merge_write(const char *path, struct recording *recording, const struct series angle[2],
                const struct clock_fit *clock, struct merge_result *result, struct app_error *error) {
  uint32_t channels =
      TL_CHANNEL_BIT(TL_CHANNEL_SHANK) | TL_CHANNEL_BIT(TL_CHANNEL_FOOT) | TL_CHANNEL_BIT(TL_CHANNEL_VALID);
  int decimals[TL_CHANNEL_COUNT];
  for (int c = 0; c < TL_CHANNEL_COUNT; c++) {
    decimals[c] = c == TL_CHANNEL_VALID ? 0 : DECIMALS;
    if (recording_has(recording, (tl_channel)c)) channels |= TL_CHANNEL_BIT(c);
  }
  memset(result, 0, sizeof *result);
  struct merging m = {recording, angle, clock, result, NULL, WIDEST * usual_step(&angle[0])};
  double *memory = calloc((size_t)TL_CHANNEL_COUNT * ROWS, sizeof *memory);
  uint8_t *valid = malloc(ROWS);
  int done = memory && valid ? 0 : app_fail(error, APP_FAILED, "out of memory");
  if (done == 0) m.writer = recording_writer_open(path, channels, decimals, error);
  if (!m.writer) done = -1;
  if (done == 0) done = write_rows(&m, memory, valid, error);
  free(memory);
  free(valid);
  if (done == 0) return recording_writer_commit(m.writer, error);
  recording_writer_abandon(m.writer);
  return -1;
}
