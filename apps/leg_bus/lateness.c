/* lateness.c: see lateness.h. */
#include "lateness.h"

void lateness_add(struct lateness *l, int64_t late_ns, int64_t period_ns) {
  int64_t edge_ns = 1000;
  int class = 0;

  while (class < LATENESS_CLASSES - 1 && late_ns >= edge_ns) {
    edge_ns *= 2;
    class ++;
  }
  l->count[class]++;
  l->ticks++;
  l->over += late_ns > period_ns;
  if (late_ns > l->worst_ns) l->worst_ns = late_ns;
}

double lateness_quantile_us(const struct lateness *l, double share) {
  const double worst_us = (double)l->worst_ns / 1e3;
  unsigned long sum = 0;
  double edge_us = 1.0;

  for (int k = 0; k < LATENESS_CLASSES; k++) {
    sum += l->count[k];
    if ((double)sum >= share * (double)l->ticks) return edge_us < worst_us ? edge_us : worst_us;
    edge_us *= 2.0;
  }
  return worst_us;
}
