/* lateness.h: how late the ticks of a real-time loop began, counted in classes of doubling width. */
#ifndef LATENESS_H
#define LATENESS_H

#include <stdint.h>

#define LATENESS_CLASSES 40

struct lateness {
  unsigned long ticks, over; /* all; those later than a period */
  int64_t worst_ns;
  unsigned long count[LATENESS_CLASSES]; /* class k: below 2^k us */
};

void lateness_add(struct lateness *l, int64_t late_ns, int64_t period_ns);
/* Upper edge [us] of the class that holds this share of the ticks (0..1), or the worst of all below it. */
double lateness_quantile_us(const struct lateness *l, double share);

#endif
