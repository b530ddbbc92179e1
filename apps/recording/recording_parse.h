/* recording_parse.h: from text to rows in a spool (private to recording*.c). */
#ifndef RECORDING_PARSE_H
#define RECORDING_PARSE_H

#include <pthread.h>

#include "recording_layout.h"
#include "spool.h"

struct recording {
  struct layout layout;
  struct spool *spool;
  const struct recording *whole; /* whose spool it is, where this is an excerpt; else NULL */
  size_t every, place_rows;      /* of an excerpt, see recording_excerpt */
  size_t rows;
  double first_s, last_s, step_s;
  pthread_mutex_t reading; /* of the spool, once it is filled */
};

/* Fills a recording whose layout has begun (layout_init), the rest zero. */
int recording_parse(struct recording *recording, struct app_error *error);

#endif
