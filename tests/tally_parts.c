/* tally_parts.c: apps/acquire/source/tally.c, called with plain numbers. Compiled by test_acquire_tally.py. */
#include "../apps/acquire/source/tally.c"

/* an interface that had counted `received` and `dropped` at the beginning, and `then_...` when it vanished */
void parts_missing(const char *driver, const uint64_t begin[2], const uint64_t end[2], const uint64_t read[3],
                   uint64_t spread, uint64_t answer[4]) {
  struct tally tally;
  uint64_t first[LINK_COUNTERS] = {0}, last[LINK_COUNTERS] = {0};
  first[LINK_RX_PACKETS] = begin[0];
  first[LINK_RX_DROPPED] = begin[1];
  last[LINK_RX_PACKETS] = end[0];
  last[LINK_RX_DROPPED] = end[1];
  tally_begin(&tally, 7, driver, first);
  tally.spread = spread;
  tally.lost_before = 100;
  tally.own = read[1];
  tally.read = read[0] + (tally.counts_own ? read[1] : 0);
  const struct tally_missing m = tally_missing(&tally, last, 100 + read[2]);
  answer[0] = m.received;
  answer[1] = m.lost;
  answer[2] = m.more;
  answer[3] = (uint64_t)m.unknown;
}
