/* fixed_scalar_floating.h: what fixed_scalar_f32.h and fixed_scalar_f64.h share, once REAL is defined. */
#ifndef TALUS_FIXED_SCALAR_FLOATING_H
#define TALUS_FIXED_SCALAR_FLOATING_H

#include <stdint.h>

#define WIDE REAL /* a sum of products */
#define MUL(a, b, drop) ((a) * (b))
#define RAW(a, b) ((a) * (b))
#define DROP(wide, drop) (wide)
#define SAT(wide) (wide)
#define HOLD(wide) (wide)
#define INSIDE(wide, low, high) (wide)
#define POWER_LINE(power, slope, speed) ((power) - (slope) * (speed))
#define POWER_OF_LINE(line, limit) (line)
#define TIMES_TICKS(step, ticks, slack) ((step) * (REAL)(ticks) + (REAL)(slack))
#define CURVE_CHECK(d0, d1, rise) (void)(d1)
#define ADD(a, b) ((a) + (b))
#define LESS(a, b) ((a) - (b))
#define ADD_PART(a, u, b) ((a) + (u) * (b))
#define UNIT_Q30 ((REAL)1)
#define UNIT_Q31 ((REAL)1)

/* how many whole knots x lies behind the first, and the part u in [0, 1] of the next step; NaN: the first knot */
#define TL_CURVE_LOCATE(c, x, i, u)                                                                          \
  do {                                                                                                       \
    REAL steps_ = ((x) - (c)->first) * (c)->per_step, end_ = (REAL)((c)->n - 1);                             \
    steps_ = steps_ > (REAL)0 ? steps_ : (REAL)0;                                                            \
    steps_ = steps_ < end_ ? steps_ : end_;                                                                  \
    (i) = (int32_t)steps_;                                                                                   \
    (i) = (i) < (c)->n - 2 ? (i) : (c)->n - 2;                                                               \
    (u) = steps_ - (REAL)(i);                                                                                \
  } while (0)

#endif
