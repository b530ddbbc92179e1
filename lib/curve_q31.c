/* curve_q31.c: lookup in fixed point, see talus/curve.h. */
#include "talus/curve.h"

#include "fixed_scalar_q31.h"

#include "curve_template.h"

int32_t tl_curve_at_q31(const tl_curve_q31 *c, int32_t x, int32_t *slope, uint32_t *saturated) {
  return curve_at_q31(c, x, slope, saturated);
}
