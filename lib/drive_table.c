/* drive_table.c: the knots of a drive's tables, see talus/drive_table.h; the bound is in drive_table_bound.c. */
#include "talus/drive_table.h"

#include <math.h>

#include "drive_table_bound.h"
#include "talus/fixed.h"

#define FEWEST 33
#define ANGLE_UNIT ((double)(1 << TL_Q_ANGLE))

static void fill(const tl_transmission *t, int n, double first, double step, tl_curve_knot_f64 *knot) {
  int i;

  for (i = 0; i < n; i++) {
    double q = first + (double)i * step, ratio, slope, inside = q, d;

    /* the end knots lie some 1e-7 rad outside, where a series goes on straight and a linkage need not close: a
     * parabola from the end is as good as the function there */
    inside = inside > TL_JOINT_RANGE_RAD ? TL_JOINT_RANGE_RAD : inside;
    inside = inside < -TL_JOINT_RANGE_RAD ? -TL_JOINT_RANGE_RAD : inside;
    d = q - inside;
    tl_transmission_ratio(t, inside, &ratio, &slope);
    knot[i] =
        (tl_curve_knot_f64){tl_transmission_motor_angle(t, inside) + d * (ratio + 0.5 * d * slope), 0.0};
    ratio += d * slope;
    knot[i].rise = ratio * step;
    knot[n + i] = (tl_curve_knot_f64){ratio, slope * step};
    knot[2 * n + i] = (tl_curve_knot_f64){1.0 / ratio, -slope / (ratio * ratio) * step};
  }
}

static double steepest(const tl_curve_knot_f64 *knot, int n) {
  double most = 0.0;
  int i;

  for (i = 0; i < n; i++) {
    double rise = i + 1 < n ? knot[i + 1].value - knot[i].value : 0.0;
    most = larger(most, larger(fabs(rise), fabs(knot[i].rise)));
  }
  return most;
}

/* Rounding: 2.2 units of 2^-31 by curve_template.h, and where the lookup is off: per_step is at least 2^29 (33 knots) or
 * 2^30 (65), so its rounding, half a unit, moves x by at most 2^-25 of a step over the table, u is cut at 2^-30; the cubic
 * is at most 1.5 times as steep as the steepest of its slopes and rises. */
static double rounding(const tl_curve_knot_f64 *knot, int n) {
  return 2.2 / 2147483648.0 + 1.5 * steepest(knot, n) * (1.0 / 33554432.0 + 1.0 / 1073741824.0);
}

static tl_status make(tl_drive_table *table, const tl_transmission *t, tl_curve_knot_f64 *knot, int n) {
  /* knots at angles that Q29 has exactly */
  double step = -floor(-2.0 * TL_JOINT_RANGE_RAD * ANGLE_UNIT / (double)(n - 1)) / ANGLE_UNIT;
  double first = -0.5 * (double)(n - 1) * step, interpolation[3], *error[3];
  tl_drive_table made = {.step_rad = step};
  tl_curve_f64 *curve[3] = {&made.angle, &made.ratio, &made.inverse};
  double *scale[3] = {&made.angle_scale_rad, &made.ratio_scale, &made.inverse_scale};
  int i;

  error[0] = &made.angle_error;
  error[1] = &made.ratio_error;
  error[2] = &made.inverse_error;
  fill(t, n, first, step, knot);
  tl_drive_table_interpolation(t, first, step, n, interpolation);
  for (i = 0; i < 3; i++) {
    tl_status status;

    *scale[i] = tl_curve_bound(knot + i * n, n);
    tl_curve_divide(knot + i * n, n, *scale[i]);
    status = tl_curve_init_f64(curve[i], knot + i * n, n, first, step);
    if (status != TL_OK) return status;
    *error[i] = interpolation[i] / *scale[i] + rounding(knot + i * n, n);
    if (!(*error[i] < 1.0)) return TL_ERR_RANGE;
  }
  *table = made;
  return TL_OK;
}

static int is_fine(const tl_drive_table *t) {
  return t->angle_error <= TL_DRIVE_TABLE_ERROR && t->ratio_error <= TL_DRIVE_TABLE_ERROR &&
         steepest(t->angle.knot, t->angle.n) <= TL_CURVE_STEEPEST &&
         steepest(t->ratio.knot, t->ratio.n) <= TL_CURVE_STEEPEST &&
         steepest(t->inverse.knot, t->inverse.n) <= TL_CURVE_STEEPEST;
}

tl_status tl_drive_table_make(tl_drive_table *table, const tl_transmission *t, tl_curve_knot_f64 *knot) {
  tl_drive_table made;
  tl_status status = TL_ERR_UNSUPPORTED;
  int n;

  if (!table || !t || !knot) return TL_ERR_ARGUMENT;
  if (t->kind != TL_TRANSMISSION_SCREW_LINKAGE && t->kind != TL_TRANSMISSION_FOURIER)
    return TL_ERR_UNSUPPORTED;
  for (n = FEWEST; n <= TL_CURVE_MAX_KNOTS; n = 2 * n - 1) {
    status = make(&made, t, knot, n);
    if (status != TL_OK) return status;
    if (is_fine(&made)) break;
  }
  *table = made;
  return TL_OK;
}
