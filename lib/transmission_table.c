/* transmission_table.c: cubic Hermite interpolation between evenly spaced knots.
 *
 * The motor angle is the Hermite cubic of (motor, ratio), the ratio that of
 * (ratio, ratio_slope), and the slope is the derivative of the latter: so slope
 * is exactly d ratio / d joint, which energy conservation needs, and motor and
 * ratio have continuous slopes. Both err by h^4 / 384 times the largest fourth
 * derivative of what they interpolate (de Boor 1978).
 */
#include <math.h>

#include "talus/transmission.h"
#include "transmission_internal.h"

/* where q lies: knots i and i + 1, part u of the way, or beyond an end */
typedef struct table_place {
  const tl_table_knot *knot;
  double u;
  double beyond_rad; /* < 0 before the first knot, > 0 after the last, else 0 */
} table_place;

static table_place locate(const tl_table *t, double q) {
  double steps = (q - t->first_rad) / t->step_rad, last = (double)(t->n - 1), whole;
  table_place p = {t->knot, 0.0, 0.0};

  /* NaN takes the first branch and stays NaN */
  if (!(steps >= 0.0)) {
    p.beyond_rad = q - t->first_rad;
  } else if (steps >= last) {
    p.knot = t->knot + (t->n - 2);
    p.u = 1.0;
    p.beyond_rad = q - (t->first_rad + last * t->step_rad);
  } else {
    whole = floor(steps);
    p.knot = t->knot + (size_t)whole;
    p.u = steps - whole;
  }
  return p;
}

/* Hermite cubic between two knots `step` apart and its derivative */
static double hermite(const double y[2], const double dy[2], double step, double u, double *derivative) {
  double rise = y[1] - y[0], d0 = step * dy[0], d1 = step * dy[1];
  double c2 = 3.0 * rise - 2.0 * d0 - d1, c3 = d0 + d1 - 2.0 * rise;

  *derivative = (d0 + u * (2.0 * c2 + u * (3.0 * c3))) / step;
  return y[0] + u * (d0 + u * (c2 + u * c3));
}

double tl_table_motor_angle(const tl_table *t, double joint_rad) {
  table_place p = locate(t, joint_rad);
  double y[2] = {p.knot[0].motor_rad, p.knot[1].motor_rad}, dy[2] = {p.knot[0].ratio, p.knot[1].ratio};
  double derivative, motor = hermite(y, dy, t->step_rad, p.u, &derivative);

  return motor + derivative * p.beyond_rad;
}

void tl_table_ratio(const tl_table *t, double joint_rad, double *ratio, double *slope) {
  table_place p = locate(t, joint_rad);
  double y[2] = {p.knot[0].ratio, p.knot[1].ratio};
  double dy[2] = {p.knot[0].ratio_slope, p.knot[1].ratio_slope};
  double value = hermite(y, dy, t->step_rad, p.u, slope);

  if (p.beyond_rad != 0.0) *slope = 0.0;
  /* adds nothing to a number, but lets NaN through */
  *ratio = value + 0.0 * p.beyond_rad;
}

/* One step's cubics are monotone and of one sign. Motor: the ratios at its ends
 * are within 3 times the mean ratio (Fritsch and Carlson 1980). Ratio: what the
 * slopes can add stays below the smaller end, since the Hermite basis of a slope
 * is at most 4/27. */
static int step_is_sound(const tl_table_knot *k, double step_rad) {
  double mean = (k[1].motor_rad - k[0].motor_rad) / step_rad;
  double side = mean > 0.0 ? 1.0 : -1.0, r0 = side * k[0].ratio, r1 = side * k[1].ratio;
  double dip = 4.0 / 27.0 * step_rad * (fabs(k[0].ratio_slope) + fabs(k[1].ratio_slope));
  double smaller = r0 < r1 ? r0 : r1, larger = r0 < r1 ? r1 : r0;

  return smaller > dip && larger <= 3.0 * side * mean && tl_is_finite(mean);
}

tl_status tl_transmission_table(tl_transmission *t, const tl_table_knot *knot, size_t n, double first_rad,
                                double step_rad) {
  tl_transmission made = {.kind = TL_TRANSMISSION_TABLE};
  size_t i;

  if (!t || !knot || n < 2) return TL_ERR_ARGUMENT;
  if (!tl_is_finite(first_rad) || !tl_is_finite(step_rad) || !(step_rad > 0.0)) return TL_ERR_RANGE;
  for (i = 0; i + 1 < n; i++)
    if (!step_is_sound(knot + i, step_rad) || knot[i].ratio * knot[i + 1].ratio < 0.0) return TL_ERR_RANGE;
  made.table = (tl_table){knot, n, first_rad, step_rad};
  *t = made;
  return TL_OK;
}

tl_status tl_transmission_tabulate(const tl_transmission *t, double first_rad, double last_rad,
                                   tl_table_knot *knot, size_t n) {
  double step;
  size_t i;

  if (!t || !knot || n < 2) return TL_ERR_ARGUMENT;
  step = (last_rad - first_rad) / (double)(n - 1);
  if (!tl_is_finite(step) || !(step > 0.0)) return TL_ERR_RANGE;
  for (i = 0; i < n; i++) {
    double q = first_rad + (double)i * step;

    knot[i].motor_rad = tl_transmission_motor_angle(t, q);
    tl_transmission_ratio(t, q, &knot[i].ratio, &knot[i].ratio_slope);
  }
  return TL_OK;
}
