/* fixed_scalar_f32.h: the scalar that curve_template.h and controller_template.h are compiled with: float. */
#ifndef TALUS_FIXED_SCALAR_F32_H
#define TALUS_FIXED_SCALAR_F32_H

#include <stdint.h>

#define REAL float
#define WIDE float             /* a sum of products */
#define NAMED(name) name##_f32 /* tl_curve_at: tl_curve_at_f32 */
#define MUL(a, b, drop) ((a) * (b))
#define SAT(wide) (wide)
#define UNIT_Q30 1.0f
#define UNIT_Q31 1.0f

/* how many whole knots x lies behind the first, and the part u in [0, 1] of the next step; NaN: the first knot */
#define TL_CURVE_LOCATE(c, x, i, u)                                                                          \
  do {                                                                                                       \
    REAL steps_ = ((x) - (c)->first) * (c)->per_step, end_ = (REAL)((c)->n - 1);                             \
    steps_ = steps_ > 0.0f ? steps_ : 0.0f;                                                                  \
    steps_ = steps_ < end_ ? steps_ : end_;                                                                  \
    (i) = (int32_t)steps_;                                                                                   \
    (i) = (i) < (c)->n - 2 ? (i) : (c)->n - 2;                                                               \
    (u) = steps_ - (REAL)(i);                                                                                \
  } while (0)

#endif
