/* decimal.c: decimal text to double.
 *
 * Three ways, all of them exactly rounded. With w the digits as a whole number
 * and the value w 10^e:
 *
 * 1. w <= 2^53 and |e| <= 22: w and 10^|e| are doubles without error, so one
 *    multiplication or division rounds once (Clinger 1990).
 * 2. w < 2^64 and -27 <= e < 0: w / 10^k = (w / 5^k) 2^-k, and 5^27 < 2^63, so
 *    the quotient is one exact integer division whose remainder decides the rounding.
 * 3. anything else: strtod.
 */
#include "decimal.h"

#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if FLT_RADIX != 2 || DBL_MANT_DIG != 53
#error "doubles must be IEEE 754 binary64"
#endif

#define MAX_TEXT 1100 /* the longest number that strtod is asked for */

/* The pieces of a decimal number. */
struct decimal {
  uint64_t digits; /* the first 19 significant digits */
  int count;       /* significant digits read, leading zeros apart */
  int seen;        /* any digit at all */
  int exponent;    /* of ten, that goes with `digits` when count <= 19 */
  int negative;
};

static int is_digit(char c) {
  return c >= '0' && c <= '9';
}

/* digits from c on; each one after the point lowers the exponent by `step` */
static const char *read_digits(const char *c, struct decimal *d, int step) {
  const char *first = c;
  while (is_digit(*c)) {
    if (d->count < 19) d->digits = 10 * d->digits + (uint64_t)(*c - '0');
    d->count += d->count > 0 || *c != '0';
    c++;
    if (c - first > MAX_TEXT) break;
  }
  d->seen |= c != first;
  d->exponent -= step * (int)(c - first);
  return c;
}

/* "e-12"; an `e` without digits does not belong to the number */
static const char *read_exponent(const char *c, struct decimal *d) {
  if (*c != 'e' && *c != 'E') return c;
  const char *digit = c + 1;
  const int negative = *digit == '-';
  if (*digit == '-' || *digit == '+') digit++;
  if (!is_digit(*digit)) return c;
  int value = 0;
  for (; is_digit(*digit); digit++)
    if (value < 100000) value = 10 * value + (*digit - '0');
  d->exponent += negative ? -value : value;
  return digit;
}

static const char *read_decimal(const char *text, struct decimal *d) {
  const char *c = text;
  d->negative = *c == '-';
  if (*c == '-' || *c == '+') c++;
  c = read_digits(c, d, 0);
  if (*c == '.') c = read_digits(c + 1, d, 1);
  return d->seen ? read_exponent(c, d) : text;
}

#if FLT_EVAL_METHOD == 0
/* way 1; 0 where it does not hold. Every power here is a double without error. */
static int scale(uint64_t digits, int exponent, double *x) {
  static const double power_of_ten[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                        1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                        1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  if (digits > (uint64_t)1 << 53 || exponent < -22 || exponent > 22) return 0;
  const double whole = (double)(int64_t)digits;
  *x = exponent < 0 ? whole / power_of_ten[-exponent] : whole * power_of_ten[exponent];
  return 1;
}
#else
static int scale(uint64_t digits, int exponent, double *x) {
  (void)digits, (void)exponent, (void)x;
  return 0;
}
#endif

#ifdef __SIZEOF_INT128__
__extension__ typedef unsigned __int128 uint128;

static const uint64_t power_of_five[28] = {
    1u,
    5u,
    25u,
    125u,
    625u,
    3125u,
    15625u,
    78125u,
    390625u,
    1953125u,
    9765625u,
    48828125u,
    244140625u,
    1220703125u,
    UINT64_C(6103515625),
    UINT64_C(30517578125),
    UINT64_C(152587890625),
    UINT64_C(762939453125),
    UINT64_C(3814697265625),
    UINT64_C(19073486328125),
    UINT64_C(95367431640625),
    UINT64_C(476837158203125),
    UINT64_C(2384185791015625),
    UINT64_C(11920928955078125),
    UINT64_C(59604644775390625),
    UINT64_C(298023223876953125),
    UINT64_C(1490116119384765625),
    UINT64_C(7450580596923828125),
};

/* 2^e as a double, for e of a normal number */
static double power_of_two(int e) {
  const uint64_t bits = (uint64_t)(1023 + e) << 52;
  double x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

/* q 2^exponent rounded to 53 bits, ties to even; `rest` says that q was cut.
 * q >= 2^62 and the result is a normal number. */
static double round_to_double(uint64_t q, int rest, int exponent) {
  const int drop = q >> 63 ? 11 : 10;
  const uint64_t half = (uint64_t)1 << (drop - 1);
  const uint64_t low = q & (2 * half - 1);
  uint64_t kept = q >> drop;
  if (low > half || (low == half && (rest || (kept & 1)))) kept++;
  return (double)kept * power_of_two(exponent + drop);
}

/* way 2; 0 where it does not hold.
 * w' = w 2^a and d' = 5^k 2^b have their top bit at 63. n = w' 2^63 lies in
 * [2^126, 2^127) and n / d' in [2^62, 2^64): 63 or 64 bits, ten or more beyond the 53
 * that are kept, and n mod d' tells whether the rest is zero. value = (n / d') 2^(b - a - 63 - k). */
static int divide(uint64_t digits, int exponent, double *x) {
  const int k = -exponent;
  if (k < 1 || k > 27 || digits == 0) return 0;
  const uint64_t five = power_of_five[k];
  const int a = __builtin_clzll(digits), b = __builtin_clzll(five);
  const uint128 n = (uint128)(digits << a) << 63;
  const uint64_t divisor = five << b;
  const uint64_t q = (uint64_t)(n / divisor);
  *x = round_to_double(q, (uint64_t)n != q * divisor, b - a - 63 - k);
  return 1;
}
#else
static int divide(uint64_t digits, int exponent, double *x) {
  (void)digits, (void)exponent, (void)x;
  return 0;
}
#endif

static inline int round_exactly(uint64_t digits, int exponent, double *x) {
  return scale(digits, exponent, x) || divide(digits, exponent, x);
}

/* way 3: strtod reads the locale's decimal point, so it is put in place of '.' */
static enum decimal_status slow(const char *text, size_t length, double *x) {
  char copy[MAX_TEXT + 16];
  const char *point = localeconv()->decimal_point;
  const size_t point_length = strlen(point);
  size_t n = 0;
  if (length > MAX_TEXT || point_length > 8) return DECIMAL_NOT_A_NUMBER;
  for (size_t i = 0; i < length; i++) {
    if (text[i] == '.') {
      memcpy(copy + n, point, point_length);
      n += point_length;
    } else
      copy[n++] = text[i];
  }
  copy[n] = '\0';
  char *end;
  const double value = strtod(copy, &end);
  if (end != copy + n) return DECIMAL_NOT_A_NUMBER;
  if (!isfinite(value)) return DECIMAL_NOT_FINITE;
  *x = value;
  return DECIMAL_OK;
}

/* does `text` begin with `word` (lower case), in any case of letters? */
static size_t begins_with(const char *text, const char *word) {
  size_t n = 0;
  while (word[n] && (text[n] | 0x20) == word[n]) n++;
  return word[n] ? 0 : n;
}

/* what stands here is no decimal number: does it say nan or infinity? */
static enum decimal_status not_decimal(const char *text, const char **end) {
  static const char *const words[] = {".nan", "nan", ".inf", "infinity", "inf"};
  const char *c = text + (*text == '-' || *text == '+');
  for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
    const size_t n = begins_with(c, words[i]);
    if (n) {
      *end = c + n;
      return DECIMAL_NOT_FINITE;
    }
  }
  *end = text;
  return DECIMAL_NOT_A_NUMBER;
}

enum decimal_status decimal_parse(const char *text, double *x, const char **end) {
  struct decimal d = {0, 0, 0, 0, 0};
  *end = read_decimal(text, &d);
  if (*end == text) return not_decimal(text, end);
  if (d.count <= 19 && round_exactly(d.digits, d.exponent, x)) {
    if (d.negative) *x = -*x;
    return DECIMAL_OK;
  }
  return slow(text, (size_t)(*end - text), x);
}

/* ---- eight digits at a time ---------------------------------------------- */

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__

/* Up to eight digits and the number that they spell. */
struct digits {
  uint64_t value;
  int count;
};

/* The digits that the eight bytes at c begin with. A byte is a digit when byte ^ '0' is at most 9, so
 * that adding 0x76 leaves its top bit clear. The digits are pushed to the word's end with
 * zeros before them; then neighbours become one digit of base 100, 10^4, 10^8. */
static struct digits eight_digits(const char *c) {
  uint64_t word;
  memcpy(&word, c, sizeof word);
  word ^= UINT64_C(0x3030303030303030);
  const uint64_t other = (word | ((word & UINT64_C(0x7f7f7f7f7f7f7f7f)) + UINT64_C(0x7676767676767676))) &
                         UINT64_C(0x8080808080808080);
  const int count = other ? __builtin_ctzll(other) / 8 : 8;
  word = (word << 4 * (8 - count)) << 4 * (8 - count);
  word = (word * 10 + (word >> 8)) & UINT64_C(0x00ff00ff00ff00ff);
  word = (word * 100 + (word >> 16)) & UINT64_C(0x0000ffff0000ffff);
  word = (word * 10000 + (word >> 32)) & UINT64_C(0xffffffff);
  return (struct digits){word, count};
}

/* digits behind those of `value`; what `count` is adds up in *places */
static uint64_t append(uint64_t value, struct digits digits, int *places) {
  static const uint64_t power[9] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000};
  *places += digits.count;
  return value * power[digits.count] + digits.value;
}

static double with_sign(double x, int negative) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  bits |= (uint64_t)negative << 63;
  memcpy(&x, &bits, sizeof x);
  return x;
}

/* Digits, a point, digits, with at most seven before it and nineteen in all, is nearly every number
 * of a recording; whatever else takes the general way. How many digits there are is as good as
 * random, so two words of the fraction are read without a branch on it. */
enum decimal_status decimal_parse_padded(const char *text, double *x, const char **end) {
  const int negative = *text == '-';
  const char *c = text + negative;
  const struct digits whole = eight_digits(c);
  c += whole.count;
  if (whole.count == 0 || whole.count == 8 || *c++ != '.') return decimal_parse(text, x, end);
  const struct digits first = eight_digits(c);
  struct digits second = eight_digits(c + 8);
  const int full = first.count == 8;
  second.count &= -full;
  second.value &= -(uint64_t)full;
  int places = 0;
  uint64_t value = append(append(whole.value, first, &places), second, &places);
  if (second.count == 8) value = append(value, eight_digits(c + 16), &places);
  c += places;
  const int digits = places + (whole.value ? whole.count : 0);
  double size;
  if (digits > 19 || (*c | 0x20) == 'e' || !round_exactly(value, -places, &size))
    return decimal_parse(text, x, end);
  *x = with_sign(size, negative);
  *end = c;
  return DECIMAL_OK;
}

#else

enum decimal_status decimal_parse_padded(const char *text, double *x, const char **end) {
  return decimal_parse(text, x, end);
}

#endif
