/* fixed_scalar_f64.h: the scalar that curve_template.h and controller_template.h are compiled with: double. */
#ifndef TALUS_FIXED_SCALAR_F64_H
#define TALUS_FIXED_SCALAR_F64_H

#include <math.h>
#include <stdint.h>

#define REAL double
#define NAMED(name) name##_f64 /* tl_curve_at: tl_curve_at_f64 */
#define MAGNITUDE(x) fabs(x)

#include "fixed_scalar_floating.h"

/* the top bit is set where |x| > limit, or x is NaN */
#define EXCESS(x, limit) ((uint32_t) !((x) <= (limit) && -(x) <= (limit)) << 31)
#define EXCESS_APART(a, b, limit) EXCESS((a) - (b), limit)

#endif
