/* comparison.h: the same motion on the same bench with the feedforward of several models, and without any: talus-feedforward
 * --twin. */
#ifndef COMPARISON_H
#define COMPARISON_H

#include "picture.h"

#define COMPARISON_MODELS (PICTURE_RUNS - 1)

struct comparison {
  const char *truth, *motion, *report, *html; /* paths; report: JSON, html: a page; Nullable */
  double speed_lag_s;
  uint64_t seed;
  struct controller_options drives;
};

/* Runs all and prints a table: 0, or -1. */
int comparison_run(const struct comparison *c, int models, char **model, struct app_error *error);

#endif
