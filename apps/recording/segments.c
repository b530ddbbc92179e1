/* segments.c: see segments.h. */
#include "segments.h"

#include <stdlib.h>

#define CHUNK 4096

/* the scan's state from row to row */
struct scan {
  struct segments *out;
  size_t room;
  size_t begin;
  double last_s;
  int last_valid;
};

static int append(struct scan *scan, size_t end, struct app_error *error) {
  struct segments *out = scan->out;

  if (!scan->last_valid || end - scan->begin < TL_SEGMENT_MIN_ROWS) return 0;
  if (out->count == scan->room) {
    size_t room = scan->room ? 2 * scan->room : 16;
    tl_segment *grown = realloc(out->segment, room * sizeof *grown);
    if (!grown) return app_fail(error, APP_FAILED, "out of memory for %zu segments", room);
    out->segment = grown;
    scan->room = room;
  }
  out->segment[out->count++] = (tl_segment){scan->begin, end};
  return 0;
}

static int scan_chunk(struct scan *scan, size_t row, size_t n, const double *t_s, const uint8_t *valid,
                      double step_s, struct app_error *error) {
  for (size_t i = 0; i < n; i++) {
    if (row + i > 0 && tl_segment_cut(scan->last_s, t_s[i], scan->last_valid, valid[i], step_s)) {
      if (append(scan, row + i, error) != 0) return -1;
      scan->begin = row + i;
    }
    scan->last_s = t_s[i];
    scan->last_valid = valid[i];
  }
  return 0;
}

int segments_find(struct recording *recording, struct segments *out, struct app_error *error) {
  double t_s[CHUNK], *column[TL_CHANNEL_COUNT] = {NULL};
  uint8_t valid[CHUNK];
  size_t rows = recording_rows(recording), row, n;
  struct scan scan = {out, 0, 0, 0.0, 0};

  *out = (struct segments){NULL, 0};
  column[TL_CHANNEL_TIME] = t_s;
  for (row = 0; row < rows; row += n) {
    n = rows - row < CHUNK ? rows - row : CHUNK;
    if (recording_read(recording, row, n, column, valid, error) != 0) return -1;
    if (scan_chunk(&scan, row, n, t_s, valid, recording_step_s(recording), error) != 0) return -1;
  }
  return append(&scan, rows, error);
}

void segments_free(struct segments *segments) {
  free(segments->segment);
  *segments = (struct segments){NULL, 0};
}
