/* curve.c: curves are made in double and copied to float and fixed point, see talus/curve.h. */
#include "talus/curve.h"

#include <math.h>

#include "talus/fixed.h"

#define STEPS_UNIT 0x1p56 /* per_step is 2^56 over the step */

static int is_finite(double x) {
  return x - x == 0.0;
}

tl_status tl_curve_init_f64(tl_curve_f64 *c, const tl_curve_knot_f64 *knot, int n, double first,
                            double step) {
  int i;

  if (!c || !knot) return TL_ERR_ARGUMENT;
  if (n < 2 || n > TL_CURVE_MAX_KNOTS || !is_finite(first) || !is_finite(step) || !(step > 0.0))
    return TL_ERR_RANGE;
  for (i = 0; i < n; i++)
    if (!is_finite(knot[i].value) || !is_finite(knot[i].rise)) return TL_ERR_RANGE;
  *c = (tl_curve_f64){knot, n, first, 1.0 / step};
  return TL_OK;
}

double tl_curve_bound(const tl_curve_knot_f64 *knot, int n) {
  double most = 0.0;
  int i;

  for (i = 0; i + 1 < n; i++) {
    double left = fabs(knot[i].value), right = fabs(knot[i + 1].value);
    double here = (left > right ? left : right) + 4.0 / 27.0 * (fabs(knot[i].rise) + fabs(knot[i + 1].rise));
    most = here > most ? here : most;
  }
  return most;
}

void tl_curve_divide(tl_curve_knot_f64 *knot, int n, double scale) {
  int i;

  for (i = 0; i < n; i++) {
    knot[i].value /= scale;
    knot[i].rise /= scale;
  }
}

void tl_curve_to_f32(const tl_curve_f64 *c, tl_curve_knot_f32 *knot, tl_curve_f32 *out) {
  int i;

  for (i = 0; i < c->n; i++) {
    knot[i].value = (float)c->knot[i].value;
    knot[i].rise = (float)c->knot[i].rise;
  }
  *out = (tl_curve_f32){knot, c->n, (float)c->first, (float)c->per_step};
}

static int knots_fit(const tl_curve_f64 *c) {
  int i;

  for (i = 0; i < c->n; i++) {
    double rise = i + 1 < c->n ? c->knot[i + 1].value - c->knot[i].value : 0.0;
    if (fabs(c->knot[i].value) > 1.0 || fabs(c->knot[i].rise) > TL_CURVE_STEEPEST ||
        fabs(rise) > TL_CURVE_STEEPEST)
      return 0;
  }
  return 1;
}

tl_status tl_curve_to_q31(const tl_curve_f64 *c, int argument_q, tl_curve_knot_q31 *knot, tl_curve_q31 *out) {
  double unit = (double)((int64_t)1 << argument_q), span = floor((c->n - 1) / c->per_step * unit + 0.5);
  uint32_t saturated = 0, one = 0;
  tl_curve_q31 made = {knot, c->n, tl_fixed_from_double(c->first, argument_q, &saturated), 0, 0, 0};
  double per_step;
  int i;

  if (!knots_fit(c) || !(span >= 1.0) || !(span <= 4294967295.0) || saturated) return TL_ERR_RANGE;
  made.span = (uint32_t)span;
  while (made.span << made.up < (uint32_t)1 << 31) made.up++;
  /* of the true step, not of the rounded span: the lookup errs by half a unit of the argument at most */
  per_step = floor(STEPS_UNIT * c->per_step / (unit * (double)((int64_t)1 << made.up)) + 0.5);
  if (per_step == 4294967296.0) per_step = 4294967295.0;
  if (!(per_step >= 1.0) || !(per_step <= 4294967295.0)) return TL_ERR_RANGE;
  made.per_step = (uint32_t)per_step;
  for (i = 0; i < c->n; i++) {
    /* 1 is given as 1 - 2^-31 */
    knot[i].value = tl_fixed_from_double(c->knot[i].value, 31, &one);
    knot[i].rise = tl_fixed_from_double(c->knot[i].rise, 31, &one);
  }
  *out = made;
  return TL_OK;
}
