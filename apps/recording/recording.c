/* recording.c: a recording's rows, as they wait in its spool. */
#include "recording.h"

#include <stdlib.h>

#include "recording_parse.h"

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
  spool_close(recording->spool);
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

/* rows that lie together in memory, to the columns from index `at` on */
static void scatter(const struct csv_header *header, const double *row, size_t rows, size_t at,
                    double *const column[TL_CHANNEL_COUNT], uint8_t *valid) {
  for (size_t place = 0; place < header->width; place++) {
    double *out = column[header->column[place]];
    if (!out) continue;
    for (size_t i = 0; i < rows; i++) out[at + i] = row[i * header->width + place];
  }
  if (!valid) return;
  const int place = header->place_of[TL_CHANNEL_VALID];
  for (size_t i = 0; i < rows; i++)
    valid[at + i] = place < 0 || row[i * header->width + (size_t)place] != 0.0;
}

static int read_rows(struct recording *recording, size_t from, size_t n,
                     double *const column[TL_CHANNEL_COUNT], uint8_t *valid, struct app_error *error) {
  for (size_t done = 0; done < n;) {
    const double *row;
    size_t rows;
    if (spool_read(recording->spool, from + done, n - done, &row, &rows, error) != 0) return -1;
    scatter(&recording->layout.header, row, rows, done, column, valid);
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
