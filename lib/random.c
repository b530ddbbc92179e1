/* random.c: Philox4x32-10 and what is drawn from it. */
#include "talus/random.h"

#include <math.h>

#include "random_inline.h"
#include "talus/math.h"

void tl_philox4x32(const uint32_t counter[4], const uint32_t key[2], uint32_t out[4]) {
  tl_philox_inline(counter, key, out);
}

void tl_random_uniform2(uint64_t seed, uint64_t stream, uint64_t counter, double out[2]) {
  tl_random_uniform2_inline(seed, stream, counter, out);
}

void tl_random_normal2(uint64_t seed, uint64_t stream, uint64_t counter, double out[2]) {
  double u[2], sine, cosine;
  tl_random_uniform2_inline(seed, stream, counter, u);
  /* 1 - u lies in (0, 1], exactly: the logarithm stays finite */
  double radius = sqrt(-2.0 * tl_log(1.0 - u[0]));
  tl_sincos(2.0 * TL_PI * u[1], &sine, &cosine);
  out[0] = radius * cosine;
  out[1] = radius * sine;
}
