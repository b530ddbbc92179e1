/* fold.h: one pass over recordings, their rows into one factor a joint. */
#ifndef FOLD_H
#define FOLD_H

#include "common/error.h"
#include "recording/stream.h"
#include "talus/identify.h"

/* Begins as zero but for `factor`, `joints` and `task`. */
struct folding {
  tl_factor *factor; /* one a joint */
  int joints;
  const char *task; /* what the pass is for, as its progress is shown */
  int robust;       /* 1: Huber's weights at the base parameters `base` */
  double base[TL_FACTOR_MAX];
  double scale[TL_MAX_JOINTS]; /* residual's scale for Huber's weights */
  double *scratch, *weight;
  size_t room;
};

/* Empties the factors and folds all scored rows of the streams in. */
int fold_all(struct folding *f, const tl_model *model, struct stream *const *stream, int streams,
             struct app_error *error);
void fold_free(struct folding *f);

#endif
