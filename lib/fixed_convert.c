/* fixed_convert.c: between fixed point and double; apart, so that firmware need not link doubles. */
#include <math.h>

#include "talus/fixed.h"

int32_t tl_fixed_from_double(double x, int n, uint32_t *saturated) {
  double scaled = floor(x * (double)((int64_t)1 << n) + 0.5);

  if (scaled >= -2147483648.0 && scaled <= 2147483647.0) return (int32_t)scaled;
  *saturated = 1;
  return x > 0.0 ? INT32_MAX : x < 0.0 ? INT32_MIN : 0;
}

double tl_fixed_to_double(int32_t q, int n) {
  return (double)q / (double)((int64_t)1 << n);
}
