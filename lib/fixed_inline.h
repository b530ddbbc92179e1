/* fixed_inline.h: fixed-point operations for hot loops; talus/fixed.h has the same as functions.
 *
 * Notation: [a, b] is the range of a value. Every routine is defined for all its arguments; where an argument's
 * range is less than its type's, the caller's line says why. Only what is
 * out of range takes another path. Eva (tests/proof)
 * shows of all of them that nothing overflows and that no shift is undefined.
 */
#ifndef TALUS_FIXED_INLINE_H
#define TALUS_FIXED_INLINE_H

#include <stdint.h>

/* Any int64. It fits where its high word is its low word's sign; the low word is then the value (conversion modulo 2^32,
 * as every compiler for these machines does). Else the end on the side of its sign. */
static inline int32_t tl_saturate(int64_t wide, uint32_t *saturated) {
  uint32_t low = (uint32_t)((uint64_t)wide), high = (uint32_t)((uint64_t)wide >> 32);
  int32_t held = (int32_t)low;

  if (high != 0U - (low >> 31)) {
    held = wide < 0 ? INT32_MIN : INT32_MAX;
    *saturated = 1;
  }
  return held;
}

/* wide / 2^drop, rounded, drop 1..62, |wide| < 2^63 - 2^61. */
static inline int64_t tl_drop(int64_t wide, int drop) {
  return (wide + ((int64_t)1 << (drop - 1))) >> drop;
}

/* The top bit is set where |x| > limit, limit >= 0: |x| is in [0, 2^31] and limit - |x| in [-2^31, 2^31 - 1]. */
static inline uint32_t tl_excess(uint32_t x, int32_t limit) {
  return (uint32_t)limit - (x >> 31 ? 0U - x : x);
}

/* a b / 2^drop, rounded. |a b| <= 2^62; half of 2^drop is at most 2^61, so the sum is below 2^63.
 * Result: |.| <= 2^(62 - drop) + 1. */
static inline int64_t tl_product(int32_t a, int32_t b, int drop) {
  return tl_drop((int64_t)a * b, drop);
}

/* sin(pi/2 r) / r and (1 - cos(pi/2 r)) / r^2 in z = r^2, [0, 1/4], Q30: Chebyshev interpolation, errors 6.8e-12
 * and 8.9e-13 */
#define TL_FIXED_SIN_0 1686629713
#define TL_FIXED_SIN_1 (-693598667)
#define TL_FIXED_SIN_2 85569259
#define TL_FIXED_SIN_3 (-5026471)
#define TL_FIXED_SIN_4 169873
#define TL_FIXED_COS_0 1324675879
#define TL_FIXED_COS_1 (-272375560)
#define TL_FIXED_COS_2 22401986
#define TL_FIXED_COS_3 (-986980)
#define TL_FIXED_COS_4 26746
#define TL_FIXED_2_PI 1367130551 /* 2 / pi in Q31 */

/* One step of Horner's scheme: c + z p / 2^32, rounded, in one multiplication that adds: c stands in the high word of the
 * sum and a half below it. z in Q32 [0, 2^30], p in Q30: |z p| / 2^32 <= |p| / 4, so from |c|, |p| < 2^30.7 the result stays
 * below 2^31 and the sum below 2^63. */
static inline int32_t tl_horner(int32_t c, int32_t z, int32_t p) {
  int64_t from = (int64_t)c * ((int64_t)1 << 32) + ((int64_t)1 << 31);

  return (int32_t)((from + (int64_t)z * p) >> 32);
}

/* The same modulo 2^32, defined for all arguments. */
static inline int32_t tl_horner_modulo(int32_t c, int32_t z, int32_t p) {
  uint64_t sum = ((uint64_t)(uint32_t)c << 32 | 0x80000000U) + (uint64_t)((int64_t)z * p);

  return (int32_t)(uint32_t)(sum >> 32);
}

/* 1. quarters = x 2 / pi: Q29 times Q31 is Q60; |x| <= 2^31 and 2^30.35 give 2^61.35.
 * 2. turn = quarters rounded to a whole number: [-3, 3]; the bits below 1 are quarters - turn in [-1/2, 1/2), of which
 *    the highest 32, signed, are cut off: Q32, [-2^31, 2^31 - 1]. Rounded to Q31: r in [-2^30, 2^30].
 * 3. z = r^2 in Q32: [0, 2^28 + 1] * 4 = [0, 2^30].
 * 4. Horner: every partial sum is below 1.5708 in Q30 < 2^30.7, and what is added is at most a quarter of one.
 * 5. sine = r p: |r| <= 2^30 in Q31 and p <= 1.5708 give at most 0.7854, and by the series 0.7072: below 2^31.
 *    cosine = 1 - z p: z p in [0, 0.2929] in Q31; 2^31 - 1 stands for 1, so the cosine is in [0.7071, 1 - 2^-31].
 * 6. the quadrant exchanges and negates; neither value is -2^31, so negation stays in range.
 * Error: 2/pi rounded 2^-33 times |x| <= 4: 7.3e-10 rad; r rounded 3.7e-10 rad; products and sums 4.7e-10. */
static inline void tl_sincos_fixed(int32_t angle_q29, int32_t *sine, int32_t *cosine) {
  int64_t quarters = (int64_t)angle_q29 * TL_FIXED_2_PI;
  int32_t turn = ((int32_t)(quarters >> 32) + ((int32_t)1 << 27)) >> 28;
  int32_t rest = (int32_t)(uint32_t)((uint64_t)quarters >> 28);
  int32_t r = (rest >> 1) + (rest & 1), z = (int32_t)tl_drop((int64_t)r * r, 30), p, s, c;

  p = tl_horner(TL_FIXED_SIN_3, z, TL_FIXED_SIN_4);
  p = tl_horner(TL_FIXED_SIN_2, z, p);
  p = tl_horner(TL_FIXED_SIN_1, z, p);
  p = tl_horner(TL_FIXED_SIN_0, z, p);
  s = (int32_t)tl_product(r, p, 30);
  p = tl_horner(TL_FIXED_COS_3, z, TL_FIXED_COS_4);
  p = tl_horner(TL_FIXED_COS_2, z, p);
  p = tl_horner(TL_FIXED_COS_1, z, p);
  p = tl_horner(TL_FIXED_COS_0, z, p);
  c = INT32_MAX - (int32_t)tl_product(z, p, 31);

  *sine = turn & 1 ? c : s;
  *cosine = turn & 1 ? s : c;
  *sine = turn & 2 ? -*sine : *sine;
  *cosine = (turn + 1) & 2 ? -*cosine : *cosine;
}

#endif
