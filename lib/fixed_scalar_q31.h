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
/* Q26 less Q23 times Q25, in Q16: |.| <= 2^21 + 2^30 + 1; rounded down. Then no more than a limit, in Q26. */
#define POWER_LINE(power, slope, speed) (((power) >> 10) - (int32_t)((int64_t)(slope) * (speed) >> 32) - 1)
#define POWER_OF_LINE(line, limit) ((line) < (limit) >> 10 ? (line)*1024 : (limit))
/* modulo 2^32, where it does not fit */
#define TIMES_TICKS(step, ticks, slack) ((int32_t)((uint32_t)(step) * (uint32_t)(ticks) + (uint32_t)(slack)))
#define UNIT_Q30 ((int32_t)1 << 30)
#define UNIT_Q31 INT32_MAX

/* Where x lies: knots i and i + 1, u in Q31, [0, 2^31 - 1].
 * x - first is held in [0, span], span < 2^32; 2^up of it wraps in no valid curve, and is defined in any.
 * steps = it times per_step: at most 2^64 - 2^33 + 1, Q56. i = its whole part, below 2^8, held in [0, n - 2].
 * What is left is below 1, or held there: its bits 25 to 55 are u. */
#define TL_CURVE_LOCATE(c, x, i, u)                                                                          \
  do {                                                                                                       \
    uint32_t way_ = (x) > (c)->first ? (uint32_t)(x) - (uint32_t)(c)->first : 0U, high_;                     \
    uint64_t steps_;                                                                                         \
    way_ = way_ < (c)->span ? way_ : (c)->span;                                                              \
    steps_ = (uint64_t)(way_ << ((c)->up & 31U)) * (c)->per_step;                                            \
    high_ = (uint32_t)(steps_ >> 32);                                                                        \
    (i) = (int32_t)(high_ >> 24);                                                                            \
    (i) = (i) < (c)->n - 2 ? (i) : (c)->n - 2;                                                               \
    high_ -= (uint32_t)(i) << 24;                                                                            \
    (u) = high_ >> 24 ? INT32_MAX : (int32_t)(high_ << 7 | (uint32_t)steps_ >> 25);                          \
  } while (0)

/* A curve's knots whose rises are beyond 2^31 / 12, which tl_curve_to_q31 lets through in no curve: flagged, and the curve
 * is its left knot's value. The top bit of STEEP + x or STEEP - x is set where |x| > STEEP. */
#define TL_STEEPEST_Q31 178956970U
static inline uint32_t tl_steep(int32_t x) {
  return (TL_STEEPEST_Q31 + (uint32_t)x) | (TL_STEEPEST_Q31 - (uint32_t)x);
}
#define CURVE_CHECK(d0, d1, rise)                                                                            \
  do {                                                                                                       \
    if ((tl_steep(d0) | tl_steep(d1) | tl_steep(rise)) >> 31) {                                              \
      (d0) = (d1) = (rise) = 0;                                                                              \
      *saturated = 1;                                                                                        \
    }                                                                                                        \
  } while (0)
#define ADD(a, b) ((int32_t)((uint32_t)(a) + (uint32_t)(b))) /* modulo 2^32 */
#define LESS(a, b) ((int32_t)((uint32_t)(a) - (uint32_t)(b)))
#define ADD_PART(a, u, b) tl_horner_modulo((a), (u), ADD(b, b)) /* a + u b, u in Q31, |b| < 2^30 */

#endif
