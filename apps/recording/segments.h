/* segments.h: the usable segments of a recording, found in bounded memory. */
#ifndef SEGMENTS_H
#define SEGMENTS_H

#include "common/error.h"
#include "recording.h"
#include "talus/score.h"

struct segments {
  tl_segment *segment;
  size_t count;
};

/* Fills `out`, to be freed by segments_free; -1 when the recording cannot be read. */
int segments_find(struct recording *recording, struct segments *out, struct app_error *error);
void segments_free(struct segments *segments);

#endif
