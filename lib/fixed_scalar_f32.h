/* fixed_scalar_f32.h: the scalar that curve_template.h and controller_template.h are compiled with: float. */
#ifndef TALUS_FIXED_SCALAR_F32_H
#define TALUS_FIXED_SCALAR_F32_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#define REAL float
#define NAMED(name) name##_f32 /* tl_curve_at: tl_curve_at_f32 */
#define MAGNITUDE(x) fabsf(x)

#include "fixed_scalar_floating.h"

/* The top bit is set where |x| > limit >= 0, or x is NaN: without the sign, a float's bits are in the order of its
 * value, and NaN lies above infinity. */
static inline uint32_t tl_excess_float(float x, float limit) {
  uint32_t bits, most;

  memcpy(&bits, &x, sizeof bits);
  memcpy(&most, &limit, sizeof most);
  return most - (bits & 0x7fffffffU);
}
#define EXCESS(x, limit) tl_excess_float((x), (limit))
#define EXCESS_APART(a, b, limit) tl_excess_float((a) - (b), (limit))

#endif
