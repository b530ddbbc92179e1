/* drive_table_bound.h: what interpolation does to a drive's tables, inside lib/. */
#ifndef TALUS_DRIVE_TABLE_BOUND_H
#define TALUS_DRIVE_TABLE_BOUND_H

#include "talus/transmission.h"

/* NaN only where both are */
static inline double larger(double a, double b) {
  return a > b || b != b ? a : b;
}

static inline double smaller(double a, double b) {
  return a < b || b != b ? a : b;
}

/* Bounds of |table - true curve| between n knots from `first`, `step` apart: motor angle, ratio, 1 / ratio.
 * Infinite where the ratio may be 0 or the linkage may not close. */
void tl_drive_table_interpolation(const tl_transmission *t, double first, double step, int n,
                                  double bound[3]);

#endif
