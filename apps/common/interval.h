/* interval.h: between which two of many instants one lies.
 *
 *     const double t_s[] = {0.0, 0.5, 1.0};
 *     size_t i = interval_of(t_s, 3, 0.7);  // 1: from 0.5 to 1.0
 */
#ifndef INTERVAL_H
#define INTERVAL_H

#include <stddef.h>

/* The last of t_s (n >= 2, rising) that is not above at_s, but the first where all are, and never the last: of an instant
 * within, the i with t_s[i] <= at_s <= t_s[i + 1]. */
size_t interval_of(const double *t_s, size_t n, double at_s);

#endif
