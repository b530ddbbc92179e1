/* math.c: elementary functions from + - * / sqrt fabs floor alone.
 *
 * Each function is reduced to a small interval, where a minimax polynomial
 * stands for it (math_coefficients.h), and is put together again so that the
 * last operation is the one whose rounding counts.
 */
#include "talus/math.h"

#include "math_inline.h"

#define TL_INFINITY (tl_of_bits(0x7ff0000000000000u))
#define TL_NAN (tl_of_bits(0x7ff8000000000000u))
#define TL_LARGEST_ANGLE_RAD 1e9
#define TL_1_LN2 1.44269504088896340736
#define TL_SQRT2 1.41421356237309504880

static int is_nan(double x) {
  return x != x;
}

static int is_negative(double x) {
  return (tl_bits_of(x) >> 63) != 0;
}

static double with_sign_of(double size, double sign) {
  return tl_of_bits((tl_bits_of(size) & ~TL_SIGN_BIT) | (tl_bits_of(sign) & TL_SIGN_BIT));
}

/* 2^k for -1022 <= k <= 1023 */
static double power_of_two(int k) {
  return tl_of_bits((uint64_t)(k + 1023) << 52);
}

/* a + b = sum + *rest exactly (Knuth 1969) */
static double two_sum(double a, double b, double *rest) {
  double sum = a + b;
  double part = sum - a;
  *rest = (a - (sum - part)) + (b - part);
  return sum;
}

/* r + *rest = x - k pi/2 to about 2^-95, for |x| <= 1e9; returns k's low bits
 * in *quadrant.
 *
 * |k| < 2^30 and the first three parts have 22 bits, so their products are
 * exact. x - k PI_2_FAR_0 and the next difference are multiples of the smaller
 * of ulp(x) and 2^-44 and shrink as those grow: both fit 53 bits. What is left
 * is added with its rounding error kept. */
static double reduce_far(double x, double *rest, uint64_t *quadrant) {
  double rounded = x * TL_2_PI + TL_ROUNDER;
  double k = rounded - TL_ROUNDER;
  double near = (x - k * TL_PI_2_FAR_0) - k * TL_PI_2_FAR_1;
  double low;
  double high = two_sum(near, -(k * TL_PI_2_FAR_2), &low);
  *quadrant = tl_bits_of(rounded);
  return two_sum(high, low - k * TL_PI_2_FAR_3, rest);
}

/* sin and cos of r + rest, rest being below half an ulp of r */
static void sincos_far_reduced(double r, double rest, double *s, double *c) {
  double sin_r, cos_r;
  tl_sincos_reduced(r, &sin_r, &cos_r);
  *s = sin_r + rest * cos_r;
  *c = cos_r - rest * sin_r;
}

void tl_sincos_far(double x, double *sin_x, double *cos_x) {
  if (!(fabs(x) <= TL_LARGEST_ANGLE_RAD)) {
    *sin_x = *cos_x = TL_NAN;
    return;
  }
  double rest, s, c;
  uint64_t quadrant;
  double r = reduce_far(x, &rest, &quadrant);
  sincos_far_reduced(r, rest, &s, &c);
  tl_sincos_turn(quadrant, s, c, sin_x, cos_x);
}

void tl_sincos(double x, double *sin_x, double *cos_x) {
  tl_sincos_inline(x, sin_x, cos_x);
}

double tl_sin(double x) {
  double s, c;
  tl_sincos_inline(x, &s, &c);
  return s;
}

double tl_cos(double x) {
  double s, c;
  tl_sincos_inline(x, &s, &c);
  return c;
}

double tl_tan(double x) {
  if (!(fabs(x) <= TL_LARGEST_ANGLE_RAD)) {
    return TL_NAN;
  }
  double rest, s, c;
  uint64_t quadrant;
  double r = reduce_far(x, &rest, &quadrant);
  if (r == 0.0) {
    return x; /* only x = 0: no other double is a multiple of pi/2 */
  }
  sincos_far_reduced(r, rest, &s, &c);
  return (quadrant & 1) ? -(c / s) : s / c;
}

/* atan u - u, |u| <= 1/2 */
static double atan_bend(double u) {
  double z = u * u;
  double z2 = z * z;
  double z4 = z2 * z2;
  double low = (TL_ATAN_0 + z * TL_ATAN_1) + z2 * (TL_ATAN_2 + z * TL_ATAN_3);
  double middle = (TL_ATAN_4 + z * TL_ATAN_5) + z2 * (TL_ATAN_6 + z * TL_ATAN_7);
  double high = (TL_ATAN_8 + z * TL_ATAN_9) + z2 * (TL_ATAN_10 + z * TL_ATAN_11) + z4 * TL_ATAN_12;
  return u * z * (low + z4 * (middle + z4 * high));
}

/* The angle of (x, y), neither negative, not both 0, of sizes that may be
 * added; pi minus it when from_pi. It is m pi/4 + sign * atan u, where the
 * smaller side over the larger is u itself up to 1/2, and beyond that u is
 * (small - large) / (small + large) in [-1/3, 0] and m grows by one; there the
 * difference is exact (Sterbenz 1974). Reflections change m and sign only, so
 * one rounding at the end is the one that counts. */
static double atan2_quadrant(double y, double x, int from_pi) {
  static const double base[5] = {0.0, TL_PI_4_0, 2.0 * TL_PI_4_0, TL_PI_3_4_0, 4.0 * TL_PI_4_0};
  static const double base_rest[5] = {0.0, TL_PI_4_1, 2.0 * TL_PI_4_1, TL_PI_3_4_1, 4.0 * TL_PI_4_1};
  int steep = y > x;
  double small = steep ? x : y;
  double large = steep ? y : x;
  int oblique = 2.0 * small > large;
  double u = oblique ? (small - large) / (small + large) : small / large;
  double bend = atan_bend(u);
  int m = oblique ? 1 : 0;
  double sign = 1.0;
  if (steep) {
    m = 2 - m;
    sign = -sign;
  }
  if (from_pi) {
    m = 4 - m;
    sign = -sign;
  }
  return base[m] + (sign * (u + bend) + base_rest[m]);
}

double tl_atan2(double y, double x) {
  if (is_nan(x) || is_nan(y)) {
    return TL_NAN;
  }
  double across = fabs(x), up = fabs(y);
  double large = up > across ? up : across;
  if (large == 0.0) {
    across = 1.0; /* (+0, +-0) lies on the positive axis, (-0, +-0) on the negative */
  } else if (large == TL_INFINITY) {
    across = across == large ? 1.0 : 0.0;
    up = up == large ? 1.0 : 0.0;
  } else if (large > 0x1p1000) { /* the sum must not overflow */
    across *= 0x1p-60;
    up *= 0x1p-60;
  }
  return with_sign_of(atan2_quadrant(up, across, is_negative(x)), y);
}

/* asin s - s, |s| <= 1/2, z = s^2 */
static double asin_bend(double s, double z) {
  double z2 = z * z;
  double z4 = z2 * z2;
  double low = (TL_ASIN_0 + z * TL_ASIN_1) + z2 * (TL_ASIN_2 + z * TL_ASIN_3);
  double middle = (TL_ASIN_4 + z * TL_ASIN_5) + z2 * (TL_ASIN_6 + z * TL_ASIN_7);
  double high = (TL_ASIN_8 + z * TL_ASIN_9) + z2 * (TL_ASIN_10 + z * TL_ASIN_11) + z4 * TL_ASIN_12;
  return s * z * (low + z4 * (middle + z4 * high));
}

/* acos(x) / 2 - less for 1/2 <= x <= 1, as asin sqrt((1 - x)/2); 1 - x is exact */
static double half_acos(double x, double less) {
  double z = 0.5 * (1.0 - x);
  double s = sqrt(z);
  return s + (asin_bend(s, z) - less);
}

double tl_asin(double x) {
  double size = fabs(x);
  if (!(size <= 1.0)) {
    return TL_NAN;
  }
  if (size <= 0.5) {
    return x + asin_bend(x, x * x);
  }
  return with_sign_of(2.0 * (TL_PI_4_0 - half_acos(size, TL_PI_4_1)), x);
}

double tl_acos(double x) {
  if (!(fabs(x) <= 1.0)) {
    return TL_NAN;
  }
  if (fabs(x) <= 0.5) {
    return 2.0 * TL_PI_4_0 - (x + (asin_bend(x, x * x) - 2.0 * TL_PI_4_1));
  }
  return x > 0.0 ? 2.0 * half_acos(x, 0.0) : 2.0 * (2.0 * TL_PI_4_0 - half_acos(-x, 2.0 * TL_PI_4_1));
}

/* x = k ln 2 + r with |r| <= ln(2)/2 (1 + 1e-12), |x| < 746: k times the first
 * part of ln 2 has at most 11 + 40 bits and is exact. */
double tl_exp(double x) {
  if (!(fabs(x) < 746.0)) {
    return is_nan(x) ? TL_NAN : x > 0.0 ? TL_INFINITY : 0.0;
  }
  double k = (x * TL_1_LN2 + TL_ROUNDER) - TL_ROUNDER;
  double r = (x - k * TL_LN2_0) - k * TL_LN2_1;
  double r2 = r * r;
  double r4 = r2 * r2;
  double low = (TL_EXP_0 + r * TL_EXP_1) + r2 * (TL_EXP_2 + r * TL_EXP_3);
  double high = (TL_EXP_4 + r * TL_EXP_5) + r2 * (TL_EXP_6 + r * TL_EXP_7);
  double bend = r2 * (low + r4 * (high + r4 * (TL_EXP_8 + r * TL_EXP_9)));
  /* in two factors, since 2^k itself may not be a double when the result is */
  int whole = (int)k;
  int half = whole / 2;
  return (1.0 + (r + bend)) * power_of_two(half) * power_of_two(whole - half);
}

/* x = 2^k (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)); x positive and finite.
 * Returns f, which is exact. */
static double split_mantissa(double x, double *k) {
  double shift = 0.0;
  if (x < 0x1p-1022) { /* subnormal */
    x *= 0x1p54;
    shift = -54.0;
  }
  uint64_t bits = tl_bits_of(x);
  double mantissa = tl_of_bits((bits & 0x000fffffffffffffu) | 0x3ff0000000000000u);
  double exponent = (double)((int)(bits >> 52) - 1023);
  if (mantissa >= TL_SQRT2) {
    mantissa *= 0.5;
    exponent += 1.0;
  }
  *k = exponent + shift;
  return mantissa - 1.0;
}

/* With s = f / (2 + f), ln(1 + f) = ln((1 + s)/(1 - s)) = 2 s + s z P(z), z = s^2,
 * and 2 s = f - s f: so ln(1 + f) = f - s (f - z P). The exact f leads, the
 * rounded s enters only by its product with what is small. */
double tl_log(double x) {
  if (!(x > 0.0)) {
    return x == 0.0 ? -TL_INFINITY : TL_NAN;
  }
  if (x == TL_INFINITY) {
    return x;
  }
  double k;
  double f = split_mantissa(x, &k);
  double s = f / (2.0 + f);
  double z = s * s;
  double z2 = z * z;
  double p = (TL_LOG_0 + z * TL_LOG_1) +
             z2 * ((TL_LOG_2 + z * TL_LOG_3) + z2 * ((TL_LOG_4 + z * TL_LOG_5) + z2 * TL_LOG_6));
  return k * TL_LN2_0 + (f - (s * (f - z * p) - k * TL_LN2_1));
}

static int is_whole(double x) {
  return floor(x) == x;
}

static int is_odd(double x) {
  return is_whole(x) && !is_whole(0.5 * x);
}

double tl_pow(double x, double y) {
  if (y == 0.0) {
    return 1.0;
  }
  if (is_nan(x) || is_nan(y) || (x < 0.0 && !is_whole(y))) {
    return TL_NAN;
  }
  double size = fabs(x);
  double power = size == 1.0 ? 1.0 : tl_exp(y * tl_log(size));
  return is_negative(x) && is_odd(y) ? -power : power;
}

/* tanh x - x, |x| <= 0.55 */
static double tanh_bend(double x) {
  double z = x * x;
  double z2 = z * z;
  double z4 = z2 * z2;
  double low = (TL_TANH_0 + z * TL_TANH_1) + z2 * (TL_TANH_2 + z * TL_TANH_3);
  double middle = (TL_TANH_4 + z * TL_TANH_5) + z2 * (TL_TANH_6 + z * TL_TANH_7);
  double high = (TL_TANH_8 + z * TL_TANH_9) + z2 * TL_TANH_10;
  return x * z * (low + z4 * (middle + z4 * high));
}

double tl_tanh(double x) {
  if (is_nan(x)) {
    return TL_NAN;
  }
  double size = fabs(x);
  double result = size <= 0.55 ? size + tanh_bend(size) : 1.0 - 2.0 / (tl_exp(2.0 * size) + 1.0);
  return with_sign_of(result, x);
}
