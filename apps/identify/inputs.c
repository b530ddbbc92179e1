/* inputs.c: see inputs.h. */
#include "inputs.h"

#include <stdlib.h>

#include "talus/identify.h"

void inputs_close(struct inputs *in) {
  for (int i = 0; i < in->n; i++) {
    if (in->stream) stream_close(in->stream[i]);
    if (in->recording) recording_close(in->recording[i]);
  }
  free(in->stream);
  free(in->recording);
  in->stream = NULL;
  in->recording = NULL;
  in->n = 0;
}

static int make_room(struct inputs *in, int n, struct app_error *error) {
  in->n = n;
  in->recording = calloc((size_t)n, sizeof(struct recording *));
  in->stream = calloc((size_t)n, sizeof(struct stream *));
  return in->recording && in->stream ? 0 : app_fail(error, APP_FAILED, "out of memory");
}

static int open_stream(struct inputs *in, int i, struct app_error *error) {
  const struct model_file *file = in->file;

  in->stream[i] = stream_open(in->recording[i], &file->model, &file->score, in->window, error);
  if (!in->stream[i]) return -1;
  if (in->workers) stream_set_workers(in->stream[i], in->workers);
  return stream_set_effects(in->stream[i], file->effect, file->effects, error);
}

int inputs_open(struct inputs *in, char *const *path, int n, struct app_error *error) {
  if (make_room(in, n, error) != 0) return -1;
  for (int i = 0; i < n; i++) {
    in->recording[i] = recording_open(path[i], in->file->model.plant, error);
    if (!in->recording[i] || open_stream(in, i, error) != 0) return -1;
  }
  return 0;
}

/* ---- excerpts ------------------------------------------------------------------ */

static size_t all_rows(const struct inputs *in) {
  size_t all = 0;

  for (int i = 0; i < in->n; i++) all += recording_rows(in->recording[i]);
  return all;
}

int inputs_are_long(const struct inputs *in) {
  return all_rows(in) > TL_READING_ROWS;
}

static int open_excerpt(struct inputs *out, const struct inputs *in, int i, size_t place_rows, size_t every,
                        struct app_error *error) {
  out->recording[i] = recording_excerpt(in->recording[i], place_rows, every, error);
  if (!out->recording[i]) return -1;
  if (every > 1) return open_stream(out, i, error);
  out->stream[i] = stream_open_as(in->stream[i], out->recording[i], error);
  return out->stream[i] ? 0 : -1;
}

int inputs_open_excerpts(struct inputs *out, const struct inputs *in, int whole, size_t every,
                         struct app_error *error) {
  const size_t all = all_rows(in);

  *out = (struct inputs){in->file, in->window, in->workers, NULL, NULL, 0};
  if (make_room(out, in->n, error) != 0) return -1;
  for (int i = 0; i < in->n; i++) {
    const size_t rows = recording_rows(in->recording[i]);
    if (open_excerpt(out, in, i, whole || all <= TL_READING_ROWS ? rows : tl_reading_place_rows(rows, all),
                     every, error) != 0)
      return -1;
  }
  return 0;
}
