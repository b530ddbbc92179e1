/* clocks.h: what time it is, on the clocks that stamps come from. */
#ifndef CLOCKS_H
#define CLOCKS_H

#include <stdint.h>

/* The three clocks at one instant. */
struct clock_triple {
  int64_t mono_ns, real_ns, raw_ns;
  int64_t width_ns; /* the three were read within this time */
};

int64_t clock_mono_ns(void);
int64_t clock_real_ns(void);
/* Monotonic read before and after; of five tries the narrowest, of more where none is within 20 us, for 1 ms at most. */
struct clock_triple clock_read_triple(void);
/* Sleeps to an instant of CLOCK_MONOTONIC, whatever signals come. */
void clock_sleep_until(int64_t mono_ns);

#endif
