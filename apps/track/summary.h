/* summary.h: what a film was like: pictures, times, and each marker's losses with their intervals. */
#ifndef TRACK_SUMMARY_H
#define TRACK_SUMMARY_H

#include <jansson.h>

#include "track/track_file.h"

enum { SUMMARY_WHOLE, SUMMARY_PARTIAL, SUMMARY_LOST, SUMMARY_STATES };

struct summary {
  const struct setup *setup;
  size_t pictures, gaps, count[TL_MARKER_MAX][SUMMARY_STATES];
  double first_s, last_s, step_s; /* of the first pictures, the usual one */
  int state[TL_MARKER_MAX];
  double since_s[TL_MARKER_MAX];
  json_t *interval[TL_MARKER_MAX];         /* {"state", "from_s", "to_s"} */
  double length[2], length2[2], sigma2[2]; /* sums of links' lengths [px] and of angles' variances */
  size_t lengths[2];
};

int summary_begin(struct summary *summary, const struct setup *setup, struct app_error *error);
void summary_add(struct summary *summary, const struct track_row *row);
/* Is this a film of these markers? 0, or -1 and what is missing, with status 2. */
int summary_judge(const struct summary *summary, const char *video, struct app_error *error);
/* On standard error, for people; as JSON (the caller's). To be called at the end. */
void summary_print(const struct summary *summary, const char *video);
json_t *summary_json(struct summary *summary, const char *video);
void summary_end(struct summary *summary);

#endif
