/* math_inline.h: sine, cosine and tests of numbers for hot loops, private to the library.
 *
 * The dynamics need several of them each cycle, so the code may be placed
 * where it is used; the bits are those of tl_sincos, which is this function.
 */
#ifndef TALUS_MATH_INLINE_H
#define TALUS_MATH_INLINE_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "math_coefficients.h"

#define TL_SINCOS_NEAR_RAD 1e5

/* a finite number: false for NaN and infinities */
static inline int tl_is_finite(double x) {
  return x - x == 0.0;
}

/* place of an entry in a matrix of so many columns, row after row */
static inline int tl_entry(int columns, int row, int column) {
  return row * columns + column;
}

/* Adding and taking away 1.5 * 2^52 rounds to the nearest whole number; the
 * sum's lowest bits are that number's, in two's complement. */
#define TL_ROUNDER 6755399441055744.0
#define TL_SIGN_BIT ((uint64_t)1 << 63)
#define TL_2_PI 0.63661977236758134308

/* tl_sincos for |x| beyond TL_SINCOS_NEAR_RAD, and for NaN. */
void tl_sincos_far(double x, double *sin_x, double *cos_x);

static inline uint64_t tl_bits_of(double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}

static inline double tl_of_bits(uint64_t bits) {
  double x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

/* sin and cos of r, |r| <= pi/4 (1 + 5e-5), by minimax polynomials. Powers are
 * paired (Estrin) so that the products overlap. */
static inline void tl_sincos_reduced(double r, double *sin_r, double *cos_r) {
  double z = r * r;
  double z2 = z * z;
  double s = (TL_SIN_0 + z * TL_SIN_1) + z2 * ((TL_SIN_2 + z * TL_SIN_3) + z2 * (TL_SIN_4 + z * TL_SIN_5));
  double c = (TL_COS_0 + z * TL_COS_1) + z2 * ((TL_COS_2 + z * TL_COS_3) + z2 * (TL_COS_4 + z * TL_COS_5));
  /* the sign is r's; the sum alone would make sin(-0) = -0 + 0 = +0 */
  *sin_r = tl_of_bits(tl_bits_of(r + (r * z) * s) | (tl_bits_of(r) & TL_SIGN_BIT));
  *cos_r = (1.0 - 0.5 * z) + z2 * c;
}

/* From r = x - k pi/2 back to x: odd quadrants exchange sine and cosine. By
 * masks, not branches: a joint that swings through pi/4 must not cost more. */
static inline void tl_sincos_turn(uint64_t k, double sin_r, double cos_r, double *sin_x, double *cos_x) {
  uint64_t s = tl_bits_of(sin_r), c = tl_bits_of(cos_r);
  uint64_t exchange = (s ^ c) & (0 - (k & 1));
  *sin_x = tl_of_bits(s ^ exchange ^ ((k & 2) << 62));
  *cos_x = tl_of_bits(c ^ exchange ^ (((k + 1) & 2) << 62));
}

/* Sine and cosine of |x| <= TL_SINCOS_NEAR_RAD.
 *
 * |k| <= 63662 < 2^16. k * PI_2_NEAR_0 has at most 16 + 36 bits, so it is exact, and
 * so is its difference from x, which is a multiple of 2^-53 (or k = 0) and less than 1
 * in size. The second product is below 2^-22, its rounding 2^-75; the only error that
 * counts is the rounding of r, at most 2^-54. */
static inline void tl_sincos_near(double x, double *sin_x, double *cos_x) {
  double rounded = x * TL_2_PI + TL_ROUNDER;
  double k = rounded - TL_ROUNDER;
  double r = (x - k * TL_PI_2_NEAR_0) - k * TL_PI_2_NEAR_1;
  double s, c;
  tl_sincos_reduced(r, &s, &c);
  tl_sincos_turn(tl_bits_of(rounded), s, c, sin_x, cos_x);
}

/* Sine and cosine of x [rad], see tl_sincos. */
static inline void tl_sincos_inline(double x, double *sin_x, double *cos_x) {
  if (fabs(x) <= TL_SINCOS_NEAR_RAD)
    tl_sincos_near(x, sin_x, cos_x);
  else
    tl_sincos_far(x, sin_x, cos_x);
}

/* tl_sincos of two angles at once, in one vector register where the machine has them. No overlap of the outputs. */
static inline void tl_sincos_two(double x0, double x1, double *restrict sin_x, double *restrict cos_x) {
  const double x[2] = {x0, x1};
  /* without branch and call the loop is one pass over a vector */
  for (int i = 0; i < 2; i++) tl_sincos_near(x[i], &sin_x[i], &cos_x[i]);
  for (int i = 0; i < 2; i++)
    if (!(fabs(x[i]) <= TL_SINCOS_NEAR_RAD)) tl_sincos_far(x[i], &sin_x[i], &cos_x[i]);
}

/* The same for n angles. The first loop has neither branch nor call, so that it runs in vector
 * registers; whether an angle was too large for it is told by the sign of a difference of bits. */
static inline void tl_sincos_many(const double *restrict x, size_t n, double *restrict sin_x,
                                  double *restrict cos_x) {
  uint64_t far = 0;
  for (size_t i = 0; i < n; i++) {
    far |= tl_bits_of(TL_SINCOS_NEAR_RAD) - (tl_bits_of(x[i]) & ~TL_SIGN_BIT);
    tl_sincos_near(x[i], &sin_x[i], &cos_x[i]);
  }
  for (size_t i = 0; far >> 63 && i < n; i++) {
    tl_sincos_inline(x[i], &sin_x[i], &cos_x[i]);
  }
}

#endif
