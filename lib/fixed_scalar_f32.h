/* fixed_scalar_f32.h: the scalar that curve_template.h and controller_template.h are compiled with: float. */
#ifndef TALUS_FIXED_SCALAR_F32_H
#define TALUS_FIXED_SCALAR_F32_H

#include <stdint.h>
#include <string.h>

#define REAL float
#define WIDE float             /* a sum of products */
#define NAMED(name) name##_f32 /* tl_curve_at: tl_curve_at_f32 */
#define MUL(a, b, drop) ((a) * (b))
#define RAW(a, b) ((a) * (b))
#define DROP(wide, drop) (wide)
#define SAT(wide) (wide)
#define HOLD(wide) (wide)
#define UNIT_Q30 1.0f
#define UNIT_Q31 1.0f

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

/* how many whole knots x lies behind the first, and the part u in [0, 1] of the next step; NaN: the first knot */
#define TL_CURVE_LOCATE(c, x, i, u)                                                                          \
  do {                                                                                                       \
    REAL steps_ = ((x) - (c)->first) * (c)->per_step, end_ = (REAL)((c)->n - 1);                             \
    steps_ = steps_ > 0.0f ? steps_ : 0.0f;                                                                  \
    steps_ = steps_ < end_ ? steps_ : end_;                                                                  \
    (i) = (int32_t)steps_;                                                                                   \
    (i) = (i) < (c)->n - 2 ? (i) : (c)->n - 2;                                                               \
    (u) = steps_ - (REAL)(i);                                                                                \
  } while (0)

#endif
