/* report.h: how far a prediction is off, as JSON, as words and as a page. */
#ifndef REPORT_H
#define REPORT_H

#include "common/error.h"
#include "page/torque_panels.h"
#include "recording/scored.h"
#include "recording/stream.h"

struct report {
  const tl_model *model;
  const char *recording; /* its path */
  double base[TL_MAX_BASE];
  struct scored joint[TL_MAX_JOINTS];
  struct torque_panels *panels; /* Nullable */
};

/* Scores the prediction by the model file's rule, and fills the panels where a page is wanted. 0, or -1; in either case
 * report_free. */
int report_make(struct report *report, const tl_model *model, struct stream *stream, int with_page,
                struct app_error *error);
void report_free(struct report *report);

/* P.json of the contract, atomically. */
int report_write_json(const struct report *report, const char *path, struct app_error *error);
/* Predicted against measured torque, as a page. */
int report_write_page(const struct report *report, const char *path, struct app_error *error);
/* A line a joint, to standard error. */
void report_say(const struct report *report);

#endif
