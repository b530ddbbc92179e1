/* comparison.h: the same motion on the same bench with the feedforward of several models, and without any: talus-feedforward
 * --twin. */
#ifndef COMPARISON_H
#define COMPARISON_H

#include "lockstep.h"

#define COMPARISON_MODELS 16

struct comparison {
  const char *truth, *motion, *report; /* paths; report: JSON, Nullable */
  double speed_lag_s;
  uint64_t seed;
  struct controller_options drives;
};

/* Runs all and prints a table: 0, or -1. */
int comparison_run(const struct comparison *c, int models, char **model, struct app_error *error);

#endif
