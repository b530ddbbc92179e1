/* transmission_fourier.c: the series (10, 11) and its least-squares fit. */
#include <math.h>

#include "talus/factor.h"
#include "talus/math.h"
#include "talus/transmission.h"
#include "transmission_internal.h"

#define CHECK_POINTS 257 /* where a new series' ratio is looked at */
#define SCAN_POINTS 17   /* coarse scan of omega before the golden section */
#define GOLDEN_STEPS 40  /* shrinks the bracket by 4e-9 */
#define GOLDEN 0.61803398874989484820
#define RANK_TOLERANCE 1e-14 /* low omegas make the columns nearly dependent */

/* The series within its range. One sincos; the harmonics follow by rotation. */
static tl_curve series(const tl_fourier *f, double q) {
  tl_curve sum = {f->a[0], 0.0, 0.0};
  double sin_1, cos_1, sin_j = 0.0, cos_j = 1.0;
  int j;

  tl_sincos(f->omega * q, &sin_1, &cos_1);
  for (j = 1; j <= TL_FOURIER_ORDER; j++) {
    double turned = cos_j * cos_1 - sin_j * sin_1, w = (double)j * f->omega, value;

    sin_j = sin_j * cos_1 + cos_j * sin_1;
    cos_j = turned;
    value = f->a[j] * cos_j + f->b[j - 1] * sin_j;
    sum.motor += value;
    sum.ratio += w * (f->b[j - 1] * cos_j - f->a[j] * sin_j);
    sum.slope -= w * w * value;
  }
  return sum;
}

tl_curve tl_fourier_curve(const tl_fourier *f, double joint_rad) {
  double inside = joint_rad;
  tl_curve curve;

  /* a series means nothing beyond its range: go on with the ratio of its edge */
  if (inside > TL_JOINT_RANGE_RAD) inside = TL_JOINT_RANGE_RAD;
  if (inside < -TL_JOINT_RANGE_RAD) inside = -TL_JOINT_RANGE_RAD;
  curve = series(f, inside);
  if (joint_rad != inside) {
    curve.motor += curve.ratio * (joint_rad - inside);
    curve.slope = 0.0;
  }
  return curve;
}

static int is_finite_series(const tl_fourier *f) {
  double sum = f->a[0];
  int j;

  for (j = 0; j < TL_FOURIER_ORDER; j++) sum += fabs(f->a[j + 1]) + fabs(f->b[j]);
  return tl_is_finite(sum) && tl_is_finite(f->omega);
}

tl_status tl_transmission_fourier(tl_transmission *t, const tl_fourier *fourier) {
  tl_transmission made = {.kind = TL_TRANSMISSION_FOURIER};
  double side;
  int i;

  if (!t || !fourier) return TL_ERR_ARGUMENT;
  if (!is_finite_series(fourier) || fourier->omega <= 0.0) return TL_ERR_RANGE;
  made.fourier = *fourier;
  side = series(fourier, 0.0).ratio;
  for (i = 0; i < CHECK_POINTS; i++) {
    double q = TL_JOINT_RANGE_RAD * (2.0 * (double)i / (double)(CHECK_POINTS - 1) - 1.0);
    if (!(series(fourier, q).ratio * side > 0.0)) return TL_ERR_RANGE;
  }
  *t = made;
  return TL_OK;
}

/* what a fit at one omega needs: samples of the motor angle and room for the equations */
typedef struct fit_problem {
  double range_rad;
  size_t n;
  int harmonics;
  const double *motor; /* (n) */
  double *columns;     /* (n) x (2 harmonics + 2): 1, cos, sin, cos, sin .. | motor */
} fit_problem;

static double sample_angle(double range_rad, size_t n, size_t i) {
  return range_rad * (2.0 * (double)i / (double)(n - 1) - 1.0);
}

static void fill_columns(const fit_problem *p, double omega) {
  size_t n = p->n, i;
  int j;

  for (i = 0; i < n; i++) {
    double sin_1, cos_1, sin_j = 0.0, cos_j = 1.0;

    tl_sincos(omega * sample_angle(p->range_rad, n, i), &sin_1, &cos_1);
    p->columns[i] = 1.0;
    for (j = 0; j < p->harmonics; j++) {
      double turned = cos_j * cos_1 - sin_j * sin_1;

      sin_j = sin_j * cos_1 + cos_j * sin_1;
      cos_j = turned;
      p->columns[(size_t)(2 * j + 1) * n + i] = cos_j;
      p->columns[(size_t)(2 * j + 2) * n + i] = sin_j;
    }
    p->columns[(size_t)(2 * p->harmonics + 1) * n + i] = p->motor[i];
  }
}

/* linear least squares for the coefficients at a given omega */
static tl_status fit_at(const fit_problem *p, double omega, tl_fourier *out, double *cost) {
  double x[2 * TL_FOURIER_ORDER + 1];
  tl_fourier made = {.omega = omega};
  tl_factor factor;
  tl_status status = tl_factor_init(&factor, 2 * p->harmonics + 1);
  int j;

  if (status != TL_OK) return status;
  fill_columns(p, omega);
  tl_factor_add(&factor, p->columns, p->n, p->n);
  status = tl_factor_solve(&factor, RANK_TOLERANCE, x, NULL);
  if (status != TL_OK) return status;
  *cost = tl_factor_cost(&factor, x);
  made.a[0] = x[0];
  for (j = 0; j < p->harmonics; j++) {
    made.a[j + 1] = x[2 * j + 1];
    made.b[j] = x[2 * j + 2];
  }
  *out = made;
  return TL_OK;
}

/* the best series seen so far and the omegas that still hold the optimum */
typedef struct fit_search {
  double low, high;
  double best_cost;
  tl_fourier best;
} fit_search;

static tl_status try_omega(const fit_problem *p, double omega, fit_search *s, double *cost) {
  tl_fourier series_here;
  tl_status status = fit_at(p, omega, &series_here, cost);

  if (status == TL_OK && !(*cost >= s->best_cost)) {
    s->best_cost = *cost;
    s->best = series_here;
  }
  return status;
}

/* the cost has several dips: a coarse scan chooses one, with its two neighbours as bracket */
static tl_status scan(const fit_problem *p, fit_search *s) {
  double first = s->low, step = (s->high - s->low) / (double)(SCAN_POINTS - 1), cost;
  int i;

  for (i = 0; i < SCAN_POINTS; i++) {
    double omega = first + step * (double)i, before = s->best_cost;
    tl_status status = try_omega(p, omega, s, &cost);

    if (status != TL_OK) return status;
    if (!(cost < before)) continue;
    s->low = i > 0 ? omega - step : omega;
    s->high = i < SCAN_POINTS - 1 ? omega + step : omega;
  }
  return TL_OK;
}

/* golden section between s->low and s->high (Kiefer 1953) */
static tl_status refine(const fit_problem *p, fit_search *s) {
  double at[2], cost[2] = {0.0, 0.0};
  tl_status status = TL_OK;
  int i;

  at[0] = s->high - GOLDEN * (s->high - s->low);
  at[1] = s->low + GOLDEN * (s->high - s->low);
  for (i = 0; i < 2 && status == TL_OK; i++) status = try_omega(p, at[i], s, &cost[i]);
  for (i = 0; i < GOLDEN_STEPS && status == TL_OK; i++) {
    if (cost[0] < cost[1]) {
      s->high = at[1];
      at[1] = at[0];
      cost[1] = cost[0];
      at[0] = s->high - GOLDEN * (s->high - s->low);
      status = try_omega(p, at[0], s, &cost[0]);
    } else {
      s->low = at[0];
      at[0] = at[1];
      cost[0] = cost[1];
      at[1] = s->low + GOLDEN * (s->high - s->low);
      status = try_omega(p, at[1], s, &cost[1]);
    }
  }
  return status;
}

size_t tl_fourier_fit_workspace(size_t n, int harmonics) {
  return harmonics < 1 || harmonics > TL_FOURIER_ORDER ? 0 : n * (size_t)(2 * harmonics + 3);
}

tl_status tl_fourier_fit(const tl_transmission *t, double range_rad, size_t n, int harmonics,
                         double omega_low, double omega_high, double *work, size_t work_n, tl_fourier *out) {
  fit_problem p = {range_rad, n, harmonics, work, NULL};
  fit_search s = {omega_low, omega_high, HUGE_VAL, {0.0, {0.0}, {0.0}}};
  tl_status status;
  size_t i;

  if (!t || !work || !out || harmonics < 1 || harmonics > TL_FOURIER_ORDER) return TL_ERR_ARGUMENT;
  if (!(range_rad > 0.0) || !tl_is_finite(range_rad) || !(omega_low > 0.0) || !(omega_high >= omega_low) ||
      !tl_is_finite(omega_high))
    return TL_ERR_RANGE;
  if (n < 2 * (size_t)harmonics + 1) return TL_ERR_TOO_SHORT;
  if (work_n < tl_fourier_fit_workspace(n, harmonics)) return TL_ERR_WORKSPACE;
  p.columns = work + n;
  for (i = 0; i < n; i++) work[i] = tl_transmission_motor_angle(t, sample_angle(range_rad, n, i));
  status = scan(&p, &s);
  if (status == TL_OK) status = refine(&p, &s);
  if (status != TL_OK) return status;
  if (!tl_is_finite(s.best_cost)) return TL_ERR_NOT_FINITE;
  *out = s.best;
  return TL_OK;
}
