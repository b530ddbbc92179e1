/* clocks.c: clock_gettime in nanoseconds. */
#define _GNU_SOURCE /* CLOCK_MONOTONIC_RAW */

#include "clocks.h"

#include <errno.h>
#include <time.h>

/* On a busy machine a call may last longer than what is wanted of a reading, and some tries later it does not. But whoever
 * reads the clocks also tells of emergency stops: he gives up after a millisecond. */
enum { FEWEST_TRIES = 5, NARROW_NS = 20000, LONGEST_NS = 1000000, NS_PER_S = 1000000000 };

static int64_t now(clockid_t clock) {
  struct timespec t;
  clock_gettime(clock, &t);
  return (int64_t)t.tv_sec * NS_PER_S + t.tv_nsec;
}

int64_t clock_mono_ns(void) {
  return now(CLOCK_MONOTONIC);
}

int64_t clock_real_ns(void) {
  return now(CLOCK_REALTIME);
}

struct clock_triple clock_read_triple(void) {
  struct clock_triple best = {.width_ns = INT64_MAX};
  int64_t before = now(CLOCK_MONOTONIC);
  const int64_t latest = before + LONGEST_NS;
  for (int i = 0; i < FEWEST_TRIES || (best.width_ns > NARROW_NS && before < latest); i++) {
    before = now(CLOCK_MONOTONIC);
    const int64_t real = now(CLOCK_REALTIME);
    const int64_t raw = now(CLOCK_MONOTONIC_RAW);
    const int64_t width = now(CLOCK_MONOTONIC) - before;
    if (width < best.width_ns) best = (struct clock_triple){before + width / 2, real, raw, width};
  }
  return best;
}

void clock_sleep_until(int64_t mono_ns) {
  const struct timespec t = {mono_ns / NS_PER_S, mono_ns % NS_PER_S};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR) continue;
}
