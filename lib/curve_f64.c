/* curve_f64.c: lookup in double, see talus/curve.h. */
#include "talus/curve.h"

#include "fixed_scalar_f64.h"

#include "curve_template.h"

double tl_curve_at_f64(const tl_curve_f64 *c, double x, double *slope) {
  return curve_at_f64(c, x, slope, NULL);
}
