/* curve.h: functions of one variable as tables with cubic Hermite interpolation, in double, float and Q31.
 *
 *     const double first = -1.0, step = 2.0 / 64;
 *     tl_curve_knot_f64 knot[65];
 *     for (int i = 0; i < 65; i++) { // x^3
 *       double x = first + i * step;
 *       knot[i].value = x * x * x;
 *       knot[i].rise = 3.0 * x * x * step; // the slope times the step
 *     }
 *     tl_curve_f64 curve;
 *     if (tl_curve_init_f64(&curve, knot, 65, first, step) != TL_OK) return 1;
 *     double rise, value = tl_curve_at_f64(&curve, 0.3, &rise);
 *     printf("%.3f %.2f\n", value, rise / step); // prints 0.027 0.27
 *
 * Between two knots the curve is the cubic that has their values and slopes; its error is step^4 / 384 times
 * the largest fourth derivative (de Boor 1978). Beyond its ends it keeps the end's value and slope.
 * For the float and fixed-point kinds values are in [-1, 1]: whoever uses one knows its scale.
 */
#ifndef TALUS_CURVE_H
#define TALUS_CURVE_H

#include <stddef.h>
#include <stdint.h>

#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A knot: the value there, and the slope times the distance of two knots. */
typedef struct tl_curve_knot_f64 {
  double value, rise;
} tl_curve_knot_f64;
typedef struct tl_curve_knot_f32 {
  float value, rise;
} tl_curve_knot_f32;
typedef struct tl_curve_knot_q31 {
  int32_t value, rise; /* Q31 */
} tl_curve_knot_q31;

/* Evenly spaced knots over [first, first + (n - 1) step]; `knot` is the caller's and must outlive the curve.
 * n = 0: no curve; it must not be looked up. */
typedef struct tl_curve_f64 {
  const tl_curve_knot_f64 *knot; /* (n) */
  int32_t n;
  double first, per_step; /* of the argument; 1 / step */
} tl_curve_f64;
typedef struct tl_curve_f32 {
  const tl_curve_knot_f32 *knot; /* (n) */
  int32_t n;
  float first, per_step;
} tl_curve_f32;
typedef struct tl_curve_q31 {
  const tl_curve_knot_q31 *knot; /* (n) */
  int32_t n;
  int32_t first;     /* in the argument's Q format */
  uint32_t span;     /* last - first: an argument is held inside */
  uint32_t up;       /* (x - first) 2^up is below 2^32 */
  uint32_t per_step; /* 2^56 / (step 2^up) */
} tl_curve_q31;

#define TL_CURVE_MAX_KNOTS 129
#define TL_CURVE_STEEPEST                                                                                    \
  (1.0 / 12.0) /* in Q31: largest rise, of full scale, and difference of two neighbours */

/* TL_ERR_RANGE when n is not 2..129, step not positive, or something is not finite. */
TL_CHECK tl_status tl_curve_init_f64(tl_curve_f64 *c, const tl_curve_knot_f64 *knot, int n, double first,
                                     double step);
/* The most that |curve| can be: a knot's value and 4/27 of the rises beside it. 0: the curve is 0. */
double tl_curve_bound(const tl_curve_knot_f64 *knot, int n);
/* Divides n knots by `scale`. */
void tl_curve_divide(tl_curve_knot_f64 *knot, int n, double scale);
/* The same curve in float, knots copied to `knot` (n of them). */
void tl_curve_to_f32(const tl_curve_f64 *c, tl_curve_knot_f32 *knot, tl_curve_f32 *out);
/* The same curve in Q31 of an argument in Q`argument_q`. TL_ERR_RANGE when a value leaves [-1, 1], a rise or the
 * difference of two neighbours is more than TL_CURVE_STEEPEST, or the knots are too close or too far apart for the format. */
TL_CHECK tl_status tl_curve_to_q31(const tl_curve_f64 *c, int argument_q, tl_curve_knot_q31 *knot,
                                   tl_curve_q31 *out);

/* The value at x; *slope is the derivative times the distance of two knots. */
double tl_curve_at_f64(const tl_curve_f64 *c, double x, double *slope);
float tl_curve_at_f32(const tl_curve_f32 *c, float x, float *slope);
int32_t tl_curve_at_q31(const tl_curve_q31 *c, int32_t x, int32_t *slope, uint32_t *saturated);

#ifdef __cplusplus
}
#endif
#endif
