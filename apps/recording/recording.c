/* recording.c: a recording's rows, as they wait in its spool. */
#include "recording.h"

#include <stdlib.h>

#include "recording_parse.h"
#include "step_median.h"
#include "talus/identify.h"

struct recording *recording_open(const char *path, tl_plant plant, struct app_error *error) {
  struct recording *recording = calloc(1, sizeof *recording);
  if (!recording) {
    app_fail(error, APP_FAILED, "out of memory");
    return NULL;
  }
  pthread_mutex_init(&recording->reading, NULL);
  if (layout_init(&recording->layout, path, plant, error) == 0 && recording_parse(recording, error) == 0)
    return recording;
  recording_close(recording);
  return NULL;
}

void recording_close(struct recording *recording) {
  if (!recording) return;
  if (!recording->whole) spool_close(recording->spool);
  pthread_mutex_destroy(&recording->reading);
  free(recording);
}

const char *recording_path(const struct recording *recording) {
  return recording->layout.header.path;
}

size_t recording_rows(const struct recording *recording) {
  return recording->rows;
}

int recording_has(const struct recording *recording, tl_channel channel) {
  return recording->layout.header.place_of[channel] >= 0;
}

double recording_first_s(const struct recording *recording) {
  return recording->first_s;
}

double recording_last_s(const struct recording *recording) {
  return recording->last_s;
}

double recording_step_s(const struct recording *recording) {
  return recording->step_s;
}

/* rows that lie `width` apart in memory, to the columns from index `at` on */
static void scatter(const struct csv_header *header, const double *row, size_t width, size_t rows, size_t at,
                    double *const column[TL_CHANNEL_COUNT], uint8_t *valid) {
  for (size_t place = 0; place < header->width; place++) {
    double *out = column[header->column[place]];
    if (!out) continue;
    for (size_t i = 0; i < rows; i++) out[at + i] = row[i * width + place];
  }
  if (!valid) return;
  const int place = header->place_of[TL_CHANNEL_VALID];
  for (size_t i = 0; i < rows; i++) valid[at + i] = place < 0 || row[i * width + (size_t)place] != 0.0;
}

/* the spool's row that is row `from`, and how many of the rows from there on lie evenly */
static size_t spool_row(const struct recording *recording, size_t from, size_t *even) {
  if (!recording->whole) {
    *even = recording->rows - from;
    return from;
  }
  const size_t at = from * recording->every, place = at / recording->place_rows;
  const size_t within = at % recording->place_rows;
  *even = (recording->place_rows - within + recording->every - 1) / recording->every;
  return tl_reading_place(recording->whole->rows, recording->place_rows, place) + within;
}

static int read_rows(struct recording *recording, size_t from, size_t n,
                     double *const column[TL_CHANNEL_COUNT], uint8_t *valid, struct app_error *error) {
  const size_t every = recording->whole ? recording->every : 1;
  for (size_t done = 0; done < n;) {
    const double *row;
    size_t rows;
    size_t even;
    const size_t at = spool_row(recording, from + done, &even), left = even < n - done ? even : n - done;
    if (spool_read(recording->spool, at, (left - 1) * every + 1, &row, &rows, error) != 0) return -1;
    rows = (rows + every - 1) / every;
    scatter(&recording->layout.header, row, every * recording->layout.header.width, rows, done, column,
            valid);
    done += rows;
  }
  return 0;
}

int recording_read(struct recording *recording, size_t from, size_t n, double *const column[TL_CHANNEL_COUNT],
                   uint8_t *valid, struct app_error *error) {
  if (from > recording->rows || n > recording->rows - from)
    return app_fail(error, APP_FAILED, "%s: rows beyond the end were asked for", recording_path(recording));
  pthread_mutex_lock(&recording->reading);
  const int result = read_rows(recording, from, n, column, valid, error);
  pthread_mutex_unlock(&recording->reading);
  return result;
}

/* ---- excerpts ----------------------------------------------------------------- */

#define CHUNK 4096

/* the last sample's time, and the median of the steps */
static int measure_steps(struct recording *r, struct step_median *median, struct app_error *error) {
  double t_s[CHUNK] = {0.0}, *column[TL_CHANNEL_COUNT] = {[TL_CHANNEL_TIME] = t_s};

  r->last_s = r->first_s;
  for (size_t row = 0, n; row < r->rows; row += n) {
    n = r->rows - row < CHUNK ? r->rows - row : CHUNK;
    if (recording_read(r, row, n, column, NULL, error) != 0) return -1;
    for (size_t i = 0; i < n; i++) {
      if (row + i > 0) step_median_add(median, t_s[i] - r->last_s);
      r->last_s = t_s[i];
    }
  }
  /* places of a recording are as fast as the whole */
  r->step_s = r->every > 1 ? step_median_value(median) : r->whole->step_s;
  return 0;
}

/* a recording that shares the whole one's spool, but for what must be measured; NULL when out of memory */
static struct recording *share(const struct recording *whole, size_t place_rows, size_t every) {
  struct recording *excerpt = malloc(sizeof *excerpt);

  if (!excerpt) return NULL;
  *excerpt = *whole;
  excerpt->whole = whole;
  excerpt->every = every;
  excerpt->place_rows = place_rows;
  excerpt->rows = TL_READING_PLACES * place_rows / every;
  if (TL_READING_PLACES * place_rows >= whole->rows) {
    excerpt->place_rows = whole->rows;
    excerpt->rows = (whole->rows + every - 1) / every;
  }
  pthread_mutex_init(&excerpt->reading, NULL);
  return excerpt;
}

struct recording *recording_excerpt(const struct recording *whole, size_t place_rows, size_t every,
                                    struct app_error *error) {
  struct step_median *median = step_median_new();
  struct recording *excerpt = median ? share(whole, place_rows, every) : NULL;
  int result;

  if (!excerpt)
    result = app_fail(error, APP_FAILED, "out of memory");
  else if (excerpt->rows < RECORDING_MIN_ROWS)
    result = app_fail(error, APP_BAD_INPUT, "%s: too few samples for an excerpt", recording_path(whole));
  else
    result = measure_steps(excerpt, median, error);
  step_median_free(median);
  if (result == 0) return excerpt;
  recording_close(excerpt);
  return NULL;
}
