/* number_rows.c: each number as a whole one in units of its last place. */
#include "number_rows.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>

static const double power_of_ten[NUMBER_ROWS_PLACES + 1] = {1e0, 1e1, 1e2, 1e3,  1e4,  1e5, 1e6,
                                                            1e7, 1e8, 1e9, 1e10, 1e11, 1e12};
static const double LARGEST = 0x1p52; /* below it each whole number is a double, and the half between two */
static const double NEAR =
    0x1p-50; /* of a number: its product with a power of ten is no further from the true one */

/* "%.*f" of a number below LARGEST, without its point */
static uint64_t printed(double size, int places) {
  char text[40];
  uint64_t m = 0;
  snprintf(text, sizeof text, "%.*f", places, size);
  for (const char *c = text; *c; c++)
    if (*c >= '0' && *c <= '9') m = 10 * m + (uint64_t)(*c - '0');
  return m;
}

/* the nearest whole number of last places; where the product is too near to the half between two to tell, as printf has it */
static uint64_t whole(double size, int places) {
  const double product = size * power_of_ten[places], nearest = rint(product);
  if (fabs(fabs(product - nearest) - 0.5) <= NEAR * product) return printed(size, places);
  return (uint64_t)nearest;
}

static char *put(char *text, uint64_t m, int places) {
  char digit[24];
  int n = 0;
  for (; n <= places || m; m /= 10) digit[n++] = (char)('0' + m % 10);
  while (n-- > 0) {
    *text++ = digit[n];
    if (n == places && places) *text++ = '.';
  }
  return text;
}

long number_rows(char *text, const double *x, size_t rows, int columns, const int *places) {
  char *at = text;
  for (size_t k = 0; k < rows; k++)
    for (int c = 0; c < columns; c++, x++) {
      const double size = fabs(*x);
      if (!(size * power_of_ten[places[c]] < LARGEST)) return -1;
      if (signbit(*x)) *at++ = '-';
      at = put(at, whole(size, places[c]), places[c]);
      *at++ = c + 1 < columns ? ',' : '\n';
    }
  return at - text;
}
