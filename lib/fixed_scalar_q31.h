/* fixed_scalar_q31.h: the scalar that curve_template.h and controller_template.h are compiled with: fixed point. */
#ifndef TALUS_FIXED_SCALAR_Q31_H
#define TALUS_FIXED_SCALAR_Q31_H

#include "fixed_inline.h"

#define REAL int32_t
#define WIDE int64_t           /* a sum of products; controller_template.h counts its bits */
#define NAMED(name) name##_q31 /* tl_curve_at: tl_curve_at_q31 */
#define MUL(a, b, drop) tl_product((a), (b), (drop))
#define RAW(a, b) ((int64_t)(a) * (b))
#define DROP(wide, drop) tl_drop((wide), (drop))
#define SAT(wide) tl_saturate((wide), saturated)
/* held, and no fault */
static inline int32_t tl_hold(int64_t wide) {
  uint32_t saturated = 0;

  return tl_saturate(wide, &saturated);
}
#define HOLD(wide) tl_hold(wide)
/* where no sound state and no sound model leaves the range: what is not sound is held all the same */
#define INSIDE(wide, low, high) tl_inside((wide), (low), (high))
#define MAGNITUDE(x) ((x) < 0 ? SAT(-(WIDE)(x)) : (x))
static inline int32_t tl_inside(int64_t wide, int32_t low, int32_t high) {
  int64_t above = wide > low ? wide : low;

  return above < high ? (int32_t)above : high;
}
/* the top bit is set where |x| > limit. Of a difference modulo 2^32: where both are within 2^31 - limit / 2, it is the
 * difference wherever that is within limit */
#define EXCESS(x, limit) tl_excess((uint32_t)(x), (limit))
#define EXCESS_APART(a, b, limit) tl_excess((uint32_t)(a) - (uint32_t)(b), (limit))
#define UNIT_Q30 ((int32_t)1 << 30)
#define UNIT_Q31 INT32_MAX

/* Where x lies: knots i and i + 1, u in Q30, [0, 2^30].
 * x - first is held in [0, span], span < 2^32; 2^up of it wraps in no valid curve, and is defined in any.
 * steps = it times per_step: at most 2^64 - 2^33 + 1, Q56. i = its whole part, at most 2^8, held in [0, n - 2].
 * What is left of steps then is below 2^64; in Q30 below 2^38, held in [0, 2^30]. */
#define TL_CURVE_LOCATE(c, x, i, u)                                                                          \
  do {                                                                                                       \
    int64_t way_ = (int64_t)(x) - (c)->first;                                                                \
    uint64_t steps_, rest_;                                                                                  \
    way_ = way_ > 0 ? way_ : 0;                                                                              \
    way_ = way_ < (int64_t)(c)->span ? way_ : (int64_t)(c)->span;                                            \
    steps_ = (uint64_t)((uint32_t)way_ << ((c)->up & 31U)) * (c)->per_step;                                  \
    (i) = (int32_t)(steps_ >> 56);                                                                           \
    (i) = (i) < (c)->n - 2 ? (i) : (c)->n - 2;                                                               \
    rest_ = (steps_ - ((uint64_t)(uint32_t)(i) << 56)) >> 26;                                                \
    (u) = rest_ < (uint64_t)1 << 30 ? (int32_t)rest_ : (int32_t)1 << 30;                                     \
  } while (0)

#endif
