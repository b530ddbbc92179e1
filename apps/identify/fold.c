/* fold.c: see fold.h. */
#include "fold.h"

#include <math.h>
#include <stdlib.h>

#define HUBER_K 1.345 /* 95 % efficiency on normal noise (Huber 1964) */

static int fold_room(struct folding *f, size_t n, struct app_error *error) {
  if (n <= f->room) return 0;
  free(f->scratch);
  free(f->weight);
  f->scratch = malloc((TL_MAX_ROW + 1) * n * sizeof *f->scratch);
  f->weight = malloc(n * sizeof *f->weight);
  f->room = n;
  return f->scratch && f->weight ? 0 : app_fail(error, APP_FAILED, "out of memory");
}

/* square roots of Huber's weights at the current base parameters */
static void huber_weights(const struct folding *f, const tl_rows *rows, int joint) {
  for (size_t k = 0; k < rows->n; k++) {
    double e = fabs(tl_rows_residual(rows, f->base, k)), limit = HUBER_K * f->scale[joint];
    f->weight[k] = e > limit ? sqrt(limit / e) : 1.0;
  }
}

static int fold_part(const struct stream_part *part, void *context, struct app_error *error) {
  struct folding *f = context;

  for (int j = 0; j < f->joints; j++) {
    const tl_rows *rows = &part->space->rows[j];
    if (fold_room(f, rows->n ? rows->n : 1, error) != 0) return -1;
    if (f->robust) huber_weights(f, rows, j);
    tl_rows_fold(rows, f->robust ? f->weight : NULL, f->scratch, &f->factor[j]);
  }
  return 0;
}

int fold_all(struct folding *f, const tl_model *model, struct stream *const *stream, int streams,
             struct app_error *error) {
  int index[TL_MAX_ROW];

  for (int j = 0; j < f->joints; j++)
    if (tl_factor_init(&f->factor[j], tl_row_index(model, j, index)) != TL_OK)
      return app_fail(error, APP_FAILED, "too many columns");
  for (int i = 0; i < streams; i++) {
    stream_set_task(stream[i], f->task);
    if (stream_rows(stream[i], fold_part, f, error) != 0) return -1;
  }
  return 0;
}

void fold_free(struct folding *f) {
  free(f->factor);
  free(f->scratch);
  free(f->weight);
}
