/* curve_f32.c: lookup in float, see talus/curve.h. */
#include "talus/curve.h"

#include "fixed_scalar_f32.h"

#include "curve_template.h"

float tl_curve_at_f32(const tl_curve_f32 *c, float x, float *slope) {
  return curve_at_f32(c, x, slope, NULL);
}
