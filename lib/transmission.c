/* transmission.c: one interface over the four kinds, see talus/transmission.h. */
#include "talus/transmission.h"

#include <math.h>

#include "talus/math.h"
#include "transmission_internal.h"

/* A monotone curve's root: Newton's steps converge in 4 to 6; the limit only
 * bounds the time where the curve is at the edge of monotone. */
#define INVERSE_STEPS 64

tl_status tl_transmission_fixed(tl_transmission *t, double ratio) {
  tl_transmission fixed = {.kind = TL_TRANSMISSION_FIXED, .ratio = ratio};

  if (!t) return TL_ERR_ARGUMENT;
  if (!tl_is_finite(ratio) || ratio == 0.0) return TL_ERR_RANGE;
  *t = fixed;
  return TL_OK;
}

static double linkage_motor_angle(const tl_transmission *t, double joint_rad) {
  double sin_q, cos_q;

  tl_sincos(joint_rad, &sin_q, &cos_q);
  return tl_linkage_motor_angle(t, sin_q, cos_q);
}

double tl_transmission_motor_angle(const tl_transmission *t, double joint_rad) {
  switch (t->kind) {
  case TL_TRANSMISSION_FIXED: return t->ratio * joint_rad;
  case TL_TRANSMISSION_SCREW_LINKAGE: return linkage_motor_angle(t, joint_rad);
  case TL_TRANSMISSION_FOURIER: return tl_fourier_curve(&t->fourier, joint_rad).motor;
  case TL_TRANSMISSION_TABLE: return tl_table_motor_angle(&t->table, joint_rad);
  }
  return 0.0;
}

void tl_transmission_ratio(const tl_transmission *t, double joint_rad, double *ratio, double *slope) {
  double sin_q = 0.0, cos_q = 1.0;

  if (t->kind == TL_TRANSMISSION_SCREW_LINKAGE) tl_sincos(joint_rad, &sin_q, &cos_q);
  tl_transmission_ratio_sc(t, joint_rad, sin_q, cos_q, ratio, slope);
}

void tl_transmission_ratio_sc(const tl_transmission *t, double joint_rad, double sin_q, double cos_q,
                              double *ratio, double *slope) {
  tl_curve curve;

  switch (t->kind) {
  case TL_TRANSMISSION_FIXED: break;
  case TL_TRANSMISSION_SCREW_LINKAGE: tl_linkage_ratio(t, sin_q, cos_q, ratio, slope); return;
  case TL_TRANSMISSION_FOURIER:
    curve = tl_fourier_curve(&t->fourier, joint_rad);
    *ratio = curve.ratio;
    *slope = curve.slope;
    return;
  case TL_TRANSMISSION_TABLE: tl_table_ratio(&t->table, joint_rad, ratio, slope); return;
  }
  *ratio = t->ratio;
  *slope = 0.0;
}

/* motor angle, ratio and slope of a series or table */
static tl_curve curve_at(const tl_transmission *t, double joint_rad) {
  tl_curve curve;

  if (t->kind == TL_TRANSMISSION_FOURIER) return tl_fourier_curve(&t->fourier, joint_rad);
  curve.motor = tl_table_motor_angle(&t->table, joint_rad);
  tl_table_ratio(&t->table, joint_rad, &curve.ratio, &curve.slope);
  return curve;
}

/* where a monotone curve is `motor_rad`, between low and high with these motor angles */
static double solve_between(const tl_transmission *t, double motor_rad, double low, double high,
                            const double at[2]) {
  double rising = at[1] > at[0] ? 1.0 : -1.0;
  double q = low + (high - low) * ((motor_rad - at[0]) / (at[1] - at[0]));
  int step;

  for (step = 0; step < INVERSE_STEPS; step++) {
    tl_curve here = curve_at(t, q);
    double error = here.motor - motor_rad, next = q - error / here.ratio;

    /* the root stays bracketed; where Newton leaves the bracket, halve it instead */
    if (error * rising > 0.0)
      high = q;
    else
      low = q;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    /* the next step would be below rounding: the error falls at least 1000-fold a step here */
    if (fabs(next - q) <= 1e-14) return next;
    q = next;
  }
  return q;
}

/* inverse of a curve that is a straight line outside [low, high] */
static double solve(const tl_transmission *t, double motor_rad, double low, double high) {
  double at[2], edge[2] = {low, high};
  int i;

  for (i = 0; i < 2; i++) {
    tl_curve end = curve_at(t, edge[i]);
    double beyond = (motor_rad - end.motor) / end.ratio, outward = i ? 1.0 : -1.0;

    /* at the edge or outside (or NaN, which is handed on) */
    if (!(beyond * outward < 0.0)) return edge[i] + beyond;
    at[i] = end.motor;
  }
  return solve_between(t, motor_rad, low, high, at);
}

static double table_end(const tl_table *t) {
  return t->first_rad + (double)(t->n - 1) * t->step_rad;
}

double tl_transmission_joint_angle(const tl_transmission *t, double motor_rad) {
  switch (t->kind) {
  case TL_TRANSMISSION_FIXED: return motor_rad / t->ratio;
  case TL_TRANSMISSION_SCREW_LINKAGE: return tl_linkage_joint_angle(t, motor_rad);
  case TL_TRANSMISSION_FOURIER: return solve(t, motor_rad, -TL_JOINT_RANGE_RAD, TL_JOINT_RANGE_RAD);
  case TL_TRANSMISSION_TABLE: return solve(t, motor_rad, t->table.first_rad, table_end(&t->table));
  }
  return 0.0;
}

void tl_transmission_joint_motion(const tl_transmission *t, const double motor[3], double joint[3]) {
  double q = tl_transmission_joint_angle(t, motor[0]), ratio, slope, v;

  /* motor' = k q', motor'' = k q'' + k' q'^2 */
  tl_transmission_ratio(t, q, &ratio, &slope);
  v = motor[1] / ratio;
  joint[2] = (motor[2] - slope * v * v) / ratio;
  joint[1] = v;
  joint[0] = q;
}

void tl_transmission_error(const tl_transmission *approx, const tl_transmission *reference, double range_rad,
                           size_t n, double *motor_rad, double *ratio_relative) {
  double worst_motor = 0.0, worst_ratio = 0.0;
  size_t i;

  for (i = 0; i < n; i++) {
    double q = n > 1 ? range_rad * (2.0 * (double)i / (double)(n - 1) - 1.0) : 0.0;
    double mine, truth, slope, error;

    error = tl_transmission_motor_angle(approx, q) - tl_transmission_motor_angle(reference, q);
    tl_transmission_ratio(approx, q, &mine, &slope);
    tl_transmission_ratio(reference, q, &truth, &slope);
    if (!(fabs(error) <= worst_motor)) worst_motor = fabs(error);
    error = (mine - truth) / truth;
    if (!(fabs(error) <= worst_ratio)) worst_ratio = fabs(error);
  }
  *motor_rad = worst_motor;
  *ratio_relative = worst_ratio;
}

void tl_transmission_motor_angles(const tl_transmission *t, const double *joint_rad, size_t n,
                                  double *motor_rad) {
  size_t i;

  for (i = 0; i < n; i++) motor_rad[i] = tl_transmission_motor_angle(t, joint_rad[i]);
}

void tl_transmission_joint_angles(const tl_transmission *t, const double *motor_rad, size_t n,
                                  double *joint_rad) {
  size_t i;

  for (i = 0; i < n; i++) joint_rad[i] = tl_transmission_joint_angle(t, motor_rad[i]);
}

void tl_transmission_ratios(const tl_transmission *t, const double *joint_rad, size_t n, double *ratio) {
  double slope;
  size_t i;

  for (i = 0; i < n; i++) tl_transmission_ratio(t, joint_rad[i], &ratio[i], &slope);
}
