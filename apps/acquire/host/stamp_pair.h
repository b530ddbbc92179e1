/* stamp_pair.h: the two stamps of one frame, from the thread that reads frames to one that looks now and then. */
#ifndef STAMP_PAIR_H
#define STAMP_PAIR_H

#include <stdint.h>

struct stamp_pair {
  uint32_t sequence; /* odd while a pair is being written */
  int64_t hardware_ns, real_ns;
};

/* By one thread only; never waits. */
void stamp_pair_publish(struct stamp_pair *pair, int64_t hardware_ns, int64_t real_ns);
/* The last pair, both of the same frame; 0 when there is none yet. */
int stamp_pair_read(const struct stamp_pair *pair, int64_t *hardware_ns, int64_t *real_ns);

#endif
