/* fixed.c: fixed-point operations as functions, see talus/fixed.h; their bounds stand in fixed_inline.h. */
#include "talus/fixed.h"

#include "fixed_inline.h"

int32_t tl_fixed_saturate(int64_t wide, uint32_t *saturated) {
  return tl_saturate(wide, saturated);
}

int32_t tl_fixed_multiply(int32_t a, int32_t b, int drop, uint32_t *saturated) {
  return tl_saturate(tl_product(a, b, drop), saturated);
}

void tl_fixed_sincos(int32_t angle_q29, int32_t *sine_q31, int32_t *cosine_q31) {
  tl_sincos_fixed(angle_q29, sine_q31, cosine_q31);
}
