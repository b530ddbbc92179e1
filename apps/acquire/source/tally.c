/* tally.c: counters against what was read. */
#include "tally.h"

#include <string.h>

static uint64_t less(uint64_t a, uint64_t b) {
  return a > b ? a - b : 0;
}

static uint64_t smaller(uint64_t a, uint64_t b) {
  return a < b ? a : b;
}

void tally_begin(struct tally *tally, int index, const char *driver, const uint64_t counter[LINK_COUNTERS]) {
  memset(tally, 0, sizeof *tally);
  tally->index = index;
  tally->counts_own = strcmp(driver, "vcan") == 0;
  tally->is_virtual = tally->counts_own || strcmp(driver, "vxcan") == 0;
  tally->received = counter[LINK_RX_PACKETS];
  tally->dropped = counter[LINK_RX_DROPPED];
}

/* A dropped frame may be one of the received, or one that the driver never got: not to be told apart when there are both. */
struct tally_missing tally_missing(const struct tally *tally, const uint64_t counter[LINK_COUNTERS],
                                   uint64_t lost_in_socket) {
  const uint64_t received = less(counter[LINK_RX_PACKETS], tally->received);
  const uint64_t dropped = less(counter[LINK_RX_DROPPED], tally->dropped);
  const uint64_t missing = less(received, tally->read + less(lost_in_socket, tally->lost_before));
  const uint64_t least = less(missing, tally->spread);
  struct tally_missing m = {.received = received};
  m.lost = less(least, dropped);
  m.more = missing - least + smaller(least, dropped);
  m.unknown = tally->begin_unknown || !tally->is_virtual || (!tally->counts_own && tally->own);
  return m;
}
