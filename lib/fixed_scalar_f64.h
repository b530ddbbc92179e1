/* fixed_scalar_f64.h: the scalar that curve_template.h and controller_template.h are compiled with: double. */
#ifndef TALUS_FIXED_SCALAR_F64_H
#define TALUS_FIXED_SCALAR_F64_H

#include <stdint.h>

#define REAL double
#define WIDE double            /* a sum of products */
#define NAMED(name) name##_f64 /* tl_curve_at: tl_curve_at_f64 */
#define MUL(a, b, drop) ((a) * (b))
#define RAW(a, b) ((a) * (b))
#define DROP(wide, drop) (wide)
#define SAT(wide) (wide)
#define HOLD(wide) (wide)
#define UNIT_Q30 1.0
#define UNIT_Q31 1.0

/* the top bit is set where |x| > limit, or x is NaN */
#define EXCESS(x, limit) ((uint32_t) !((x) <= (limit) && -(x) <= (limit)) << 31)
#define EXCESS_APART(a, b, limit) EXCESS((a) - (b), limit)

/* how many whole knots x lies behind the first, and the part u in [0, 1] of the next step; NaN: the first knot */
#define TL_CURVE_LOCATE(c, x, i, u)                                                                          \
  do {                                                                                                       \
    REAL steps_ = ((x) - (c)->first) * (c)->per_step, end_ = (REAL)((c)->n - 1);                             \
    steps_ = steps_ > 0.0 ? steps_ : 0.0;                                                                    \
    steps_ = steps_ < end_ ? steps_ : end_;                                                                  \
    (i) = (int32_t)steps_;                                                                                   \
    (i) = (i) < (c)->n - 2 ? (i) : (c)->n - 2;                                                               \
    (u) = steps_ - (REAL)(i);                                                                                \
  } while (0)

#endif
