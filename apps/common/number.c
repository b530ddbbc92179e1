/* number.c: doubles as decimal text. */
#include "number.h"

#include <locale.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "decimal.h"

#define DIGITS 12

/* printf writes the locale's decimal point; it becomes '.' */
static size_t put_point(char *text) {
  const char *point = localeconv()->decimal_point;
  const size_t length = strlen(point);
  char *found = strcmp(point, ".") == 0 ? NULL : strstr(text, point);
  if (found) {
    *found = '.';
    memmove(found + 1, found + length, strlen(found + length) + 1);
  }
  return strlen(text);
}

static size_t print(char text[NUMBER_TEXT], double x, int digits) {
  if (isnan(x)) return (size_t)snprintf(text, NUMBER_TEXT, "nan");
  snprintf(text, NUMBER_TEXT, "%.*g", digits, x);
  return put_point(text);
}

static int reads_back(const char *text, double x) {
  double y;
  const char *end;
  return decimal_parse(text, &y, &end) == DECIMAL_OK && y == x;
}

size_t number_exact(char text[NUMBER_TEXT], double x) {
  size_t n = number_rounded(text, x);
  for (int digits = 15; digits <= 17 && isfinite(x) && !reads_back(text, x); digits++)
    n = print(text, x, digits);
  return n;
}

static const double power_of_ten[] = {1e0, 1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7, 1e8,
                                      1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16};

/* the decimal exponent of x in [1e-5, 1e12) */
static int decimal_exponent(double x) {
  if (x < 1.0) {
    int e = -1;
    while (x * power_of_ten[-e] < 1.0) e--;
    return e;
  }
  int e = 0;
  while (x >= power_of_ten[e + 1]) e++;
  return e;
}

/* the digits m (exactly DIGITS of them), the first of which stands for 10^exponent */
static size_t put_digits(char *text, uint64_t m, int exponent) {
  char digit[DIGITS];
  for (int i = DIGITS - 1; i >= 0; i--, m /= 10) digit[i] = (char)('0' + m % 10);
  int used = DIGITS;
  while (used > 1 && used > exponent + 1 && digit[used - 1] == '0') used--;
  size_t n = 0;
  if (exponent < 0) {
    text[n++] = '0';
    text[n++] = '.';
    for (int i = -1; i > exponent; i--) text[n++] = '0';
  }
  for (int i = 0; i < used; i++) {
    if (i == exponent + 1 && exponent >= 0) text[n++] = '.';
    text[n++] = digit[i];
  }
  text[n] = '\0';
  return n;
}

size_t number_rounded(char text[NUMBER_TEXT], double x) {
  const double size = fabs(x);
  if (x == 0.0) return (size_t)snprintf(text, NUMBER_TEXT, "0");
  if (!(size >= 1e-5 && size < 1e12)) return print(text, x, DIGITS);
  int exponent = decimal_exponent(size);
  /* one rounding by the product, one to a whole number */
  uint64_t m = (uint64_t)(size * power_of_ten[DIGITS - 1 - exponent] + 0.5);
  if (m >= (uint64_t)power_of_ten[DIGITS]) {
    m /= 10;
    if (++exponent == DIGITS) return print(text, x, DIGITS);
  }
  const size_t sign = x < 0.0;
  text[0] = '-';
  return sign + put_digits(text + sign, m, exponent);
}
