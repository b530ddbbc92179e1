/* predict.h: what a model predicts at every row of a recording, as CSV. */
#ifndef PREDICT_H
#define PREDICT_H

#include "common/error.h"
#include "common/output.h"
#include "recording/recording.h"
#include "recording/stream.h"
#include "talus/plant.h"

/* Writes the header and one row for each row of the recording: time and what its current (or
 * load) column would show, from angles alone. Rows without support (gaps, `valid` = 0) hold
 * the nearest estimate in time. */
int predict_write(struct output *out, struct recording *recording, struct stream *stream,
                  const tl_model *model, struct app_error *error);

#endif
