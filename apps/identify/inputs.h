/* inputs.h: the recordings that are identified from, whole or in excerpts. */
#ifndef INPUTS_H
#define INPUTS_H

#include "common/error.h"
#include "model/model_file.h"
#include "recording/stream.h"

struct inputs {
  const struct model_file *file;
  const tl_window *window; /* the user's, or NULL */
  int workers;             /* 0: as many as there are processors */
  struct recording **recording;
  struct stream **stream;
  int n;
};

/* Opens n recordings. file, window (nullable) and workers are set before; whatever happens, inputs_close afterwards. */
int inputs_open(struct inputs *in, char *const *path, int n, struct app_error *error);
/* TL_READING_ROWS of them, or all (whole 1), every so-manieth sample: where every is 1, read as the whole ones are. */
int inputs_open_excerpts(struct inputs *out, const struct inputs *in, int whole, size_t every,
                         struct app_error *error);
void inputs_close(struct inputs *in);
/* Have the recordings more rows than their excerpts? */
int inputs_are_long(const struct inputs *in);

#endif
