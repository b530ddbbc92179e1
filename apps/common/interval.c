/* interval.c: see interval.h. */
#include "interval.h"

size_t interval_of(const double *t_s, size_t n, double at_s) {
  size_t low = 0, high = n - 1;

  while (high - low > 1) {
    const size_t middle = low + (high - low) / 2;
    if (t_s[middle] <= at_s)
      low = middle;
    else
      high = middle;
  }
  return low;
}
