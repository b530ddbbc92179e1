/* tally.h: what was read from one interface, beside what the interface itself has counted.
 *
 *     tally_begin(&tally, index, driver, counter);       as soon as the interface is the one that is recorded
 *     tally.read++;                                      each frame that its driver counts as received
 *     tally_missing(&tally, counter, lost_in_socket);    when it has vanished, and all it left has been read
 *
 * The kernel throws away without a count what is in its backlog when an interface is deleted, and says for a moment that
 * frames are sent although the interface does not take them any longer. Its last message about the interface has the counters
 * as they were after that: what they say and was not read is lost.
 *
 * That is exact for a virtual interface. In front of a real one there is the adapter, and what that had received and not yet
 * handed over when it was pulled out, nobody has counted.
 */
#ifndef TALLY_H
#define TALLY_H

#include <stdint.h>

#include "link.h"

struct tally {
  int index;                  /* 0: none */
  int counts_own;             /* its driver counts as received what this machine sent, as vcan does */
  int is_virtual;             /* there is nothing in front of it */
  int begin_unknown;          /* frames may have gone before its counters were first read */
  uint64_t received, dropped; /* its counters at the beginning */
  uint64_t spread; /* of `received`: so many may have been counted before and read behind the beginning */
  uint64_t read;   /* from it, of what its driver counts */
  uint64_t own;    /* read from it, sent by this machine */
  uint64_t lost_before; /* in the socket, until the beginning */
};

/* What an interface that vanished has not handed over. */
struct tally_missing {
  uint64_t received; /* that it counted in the time */
  uint64_t lost;     /* at least, besides those that its counter of dropped frames tells */
  uint64_t more;     /* so many more, at most; where `unknown` is set, of those that it has counted */
  int unknown;       /* and those that nobody has counted */
};

void tally_begin(struct tally *tally, int index, const char *driver, const uint64_t counter[LINK_COUNTERS]);
struct tally_missing tally_missing(const struct tally *tally, const uint64_t counter[LINK_COUNTERS],
                                   uint64_t lost_in_socket);

#endif
