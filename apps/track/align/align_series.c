/* align_series.c: cubic interpolation, and the coarse lag. */
#include <math.h>
#include <stdlib.h>

#include "common/interval.h"
#include "track/align/align.h"

#define STEP_S 0.02     /* of the coarse grid */
#define LONGEST_S 120.0 /* of the film's beginning that is looked for */
#define OVERLAP_S 5.0   /* that a lag must leave */
#define APART_S 0.4     /* of two lags that are not one peak */
#define NEAR_S 1.0      /* around an offset that is given */
#define LEAST 0.5       /* correlation below which there is no motion in common */

int series_cubic(const struct series *s, double t_s, double *value, double *slope, double *widest) {
  if (s->n < 4 || t_s < s->t_s[0] || t_s > s->t_s[s->n - 1]) return -1;
  size_t first = interval_of(s->t_s, s->n, t_s);
  first = first == 0 ? 0 : first - 1;
  if (first + 4 > s->n) first = s->n - 4;
  const double *t = s->t_s + first, *x = s->x + first;
  double sum = 0.0, change = 0.0, step = 0.0;
  for (int i = 0; i < 4; i++) { /* Lagrange's polynomials and their slopes */
    double product = 1.0, logarithmic = 0.0;
    for (int k = 0; k < 4; k++) {
      if (k == i) continue;
      double others = 1.0;
      for (int j = 0; j < 4; j++)
        if (j != i && j != k) others *= (t_s - t[j]) / (t[i] - t[j]);
      product *= (t_s - t[k]) / (t[i] - t[k]);
      logarithmic += others / (t[i] - t[k]);
    }
    sum += product * x[i];
    change += logarithmic * x[i];
    if (i > 0 && t[i] - t[i - 1] > step) step = t[i] - t[i - 1];
  }
  *value = sum;
  if (slope) *slope = change;
  if (widest) *widest = step;
  return 0;
}

/* ---- the lag ------------------------------------------------------------------- */

/* Velocity on an even grid; 0 in gaps. The caller frees; NULL when out of memory. */
static double *velocities(const struct series *s, double longest_s, size_t *n) {
  const double length = s->t_s[s->n - 1] - s->t_s[0];
  *n = (size_t)((length < longest_s ? length : longest_s) / STEP_S);
  double *v = malloc((*n + 1) * sizeof *v);
  for (size_t i = 0; v && i < *n; i++) {
    double value, widest;
    if (series_cubic(s, s->t_s[0] + (double)i * STEP_S, &value, &v[i], &widest) != 0 || widest > 0.1)
      v[i] = 0.0;
  }
  return v;
}

static double correlation(const double *a, size_t n, const double *b, size_t m, long lag) {
  const size_t from = lag < 0 ? (size_t)-lag : 0;
  const size_t to = (long)m - lag < (long)n ? (size_t)((long)m - lag) : n;
  double ab = 0.0, aa = 0.0, bb = 0.0;
  for (size_t i = from; i < to; i++) {
    const double y = b[(long)i + lag];
    ab += a[i] * y;
    aa += a[i] * a[i];
    bb += y * y;
  }
  return aa > 0.0 && bb > 0.0 ? ab / sqrt(aa * bb) : 0.0;
}

/* Correlation at every lag of a range; the caller frees. */
struct lags {
  long first, last;
  double *r; /* of first + i */
};

static int correlate(const double *a, size_t n, const double *b, size_t m, struct lags *lags) {
  long least = (long)(OVERLAP_S / STEP_S);
  if (least < (long)n / 4) least = (long)n / 4;
  if (least > (long)n) least = (long)n;
  if (lags->first < least - (long)n) lags->first = least - (long)n;
  if (lags->last > (long)m - least) lags->last = (long)m - least;
  if (lags->last < lags->first) lags->last = lags->first - 1;
  lags->r = malloc((size_t)(lags->last - lags->first + 2) * sizeof *lags->r);
  for (long lag = lags->first; lags->r && lag <= lags->last; lag++)
    lags->r[lag - lags->first] = correlation(a, n, b, m, lag);
  return lags->r ? 0 : -1;
}

/* The best lag further than `apart` from `other`. */
static long best_lag(const struct lags *lags, long other, long apart, double *best) {
  long found = lags->first;
  *best = 0.0;
  for (long lag = lags->first; lags->r && lag <= lags->last; lag++) {
    const double r = lags->r[lag - lags->first];
    if (fabs(r) <= fabs(*best) || labs(lag - other) <= apart) continue;
    *best = r;
    found = lag;
  }
  return found;
}

/* Best lag and its correlation; -1 where there is none, or where another is as good. */
static int choose(const struct lags *lags, double zero_s, struct clock_fit *clock, long *lag,
                  struct app_error *error) {
  double second;
  *lag = best_lag(lags, lags->first, -1, &clock->correlation);
  const long rival = best_lag(lags, *lag, (long)(APART_S / STEP_S), &second);
  if (fabs(clock->correlation) < LEAST)
    return app_fail(
        error, APP_BAD_INPUT,
        "film and recording have no motion in common: the shank's and the knee's velocities correlate by "
        "%.2f at best",
        clock->correlation);
  if (1.0 - fabs(second) < 2.0 * (1.0 - fabs(clock->correlation)) + 1e-3)
    return app_fail(
        error, APP_BAD_INPUT,
        "the motion repeats itself: offsets of %.2f and %.2f s fit alike, --near says which it is",
        zero_s + (double)*lag * STEP_S, zero_s + (double)rival * STEP_S);
  return 0;
}

int align_coarse(const struct align_data *data, const double *near_s, struct clock_fit *clock,
                 struct app_error *error) {
  const struct series *camera = &data->camera[0], *encoder = &data->encoder[0];
  const double zero_s = encoder->t_s[0] - camera->t_s[0]; /* offset at lag 0 */
  struct lags lags = {-1000000000, 1000000000, NULL};
  size_t n, m;
  long lag = 0;
  if (near_s) {
    lags.first = (long)floor((*near_s - zero_s - NEAR_S) / STEP_S);
    lags.last = lags.first + (long)(2.0 * NEAR_S / STEP_S);
  }
  double *a = velocities(camera, LONGEST_S, &n), *b = velocities(encoder, 1e9, &m);
  int result = a && b && correlate(a, n, b, m, &lags) == 0 ? 0 : app_fail(error, APP_FAILED, "out of memory");
  if (result == 0) result = choose(&lags, zero_s, clock, &lag, error);
  free(a);
  free(b);
  free(lags.r);
  if (result != 0) return -1;
  clock->middle_cam_s = camera->t_s[0];
  clock->middle_rec_s = encoder->t_s[0] + (double)lag * STEP_S;
  clock->rate = 0.0;
  return 0;
}
