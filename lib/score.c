/* score.c: see talus/score.h. */
#include "talus/score.h"

#include <math.h>

#include "talus/filter.h"

tl_score_settings tl_score_defaults(void) {
  tl_score_settings s = {30.0, 4, 0.008, 0.016, 0.25};
  return s;
}

/* the k-th smallest of x, which is reordered (Hoare's selection) */
static double select_kth(double *x, size_t n, size_t k) {
  size_t low = 0, high = n - 1;

  while (low < high) {
    double pivot = x[low + (high - low) / 2];
    size_t i = low, j = high;

    for (;;) {
      double swap;
      while (x[i] < pivot) i++;
      while (x[j] > pivot) j--;
      if (i >= j) break;
      swap = x[i];
      x[i++] = x[j];
      x[j--] = swap;
    }
    if (x[j] > pivot) j--;
    if (k <= j)
      high = j;
    else
      low = j + 1;
  }
  return x[k];
}

double tl_median_step(const double *t_s, size_t n, double *work) {
  size_t i, steps = n - 1;
  double upper, lower;

  for (i = 0; i < steps; i++) work[i] = t_s[i + 1] - t_s[i];
  upper = select_kth(work, steps, steps / 2);
  if (steps % 2) return upper;
  lower = work[0]; /* the largest of the lower half, which selection has put first */
  for (i = 1; i < steps / 2; i++) lower = work[i] > lower ? work[i] : lower;
  return 0.5 * (lower + upper);
}

int tl_segment_cut(double previous_s, double time_s, int previous_valid, int valid, double step_s) {
  return time_s - previous_s > TL_GAP_STEPS * step_s || previous_valid != valid;
}

int tl_segment_next(const double *t_s, const uint8_t *valid, size_t n, double step_s, size_t *cursor,
                    tl_segment *out) {
  while (*cursor < n) {
    size_t begin = *cursor, i;
    int ok = valid ? valid[begin] != 0 : 1;

    for (i = begin + 1; i < n; i++)
      if (tl_segment_cut(t_s[i - 1], t_s[i], ok, valid ? valid[i] != 0 : 1, step_s)) break;
    *cursor = i;
    if (!ok || i - begin < TL_SEGMENT_MIN_ROWS) continue;
    *out = (tl_segment){begin, i};
    return 1;
  }
  return 0;
}

size_t tl_grid_count(double begin_s, double end_s, double step_s) {
  double steps = (end_s - begin_s) / step_s;
  double whole = floor(steps);

  if (!(steps > 0.0)) return 0;
  return (size_t)(whole < steps ? whole + 1.0 : whole);
}

void tl_grid_resample_batch(const double *t_s, const double *x, size_t n, size_t series, double begin_s,
                            double step_s, double *out, size_t m) {
  size_t k, c, i = 0;

  for (k = 0; k < m; k++) {
    double at = begin_s + (double)k * step_s, step, ahead;
    size_t end = at <= t_s[0] || n < 2 ? 0 : n - 1;

    while (i + 2 < n && t_s[i + 1] <= at) i++;
    if (end == 0 || at >= t_s[n - 1]) {
      for (c = 0; c < series; c++) out[c * m + k] = x[c * n + end];
      continue;
    }
    step = t_s[i + 1] - t_s[i];
    ahead = at - t_s[i];
    for (c = 0; c < series; c++) {
      const double *row = x + c * n + i;
      out[c * m + k] = row[0] + (row[1] - row[0]) / step * ahead;
    }
  }
}

void tl_grid_resample(const double *t_s, const double *x, size_t n, double begin_s, double step_s,
                      double *out, size_t m) {
  tl_grid_resample_batch(t_s, x, n, 1, begin_s, step_s, out, m);
}

void tl_score_keep(const tl_score_settings *s, const double *speed, size_t m, double step_s, uint8_t *keep) {
  double wanted = s->guard_s / step_s, whole = floor(wanted);
  size_t guard = (size_t)(whole < wanted ? whole + 1.0 : whole);
  size_t k, since = guard + 1, i;

  /* forward: how long since a sample at standstill; then the samples before it */
  for (k = 0; k < m; k++) {
    int still = fabs(speed[k]) < s->standstill;
    since = still ? 0 : since + 1;
    keep[k] = since > guard;
    for (i = 1; still && i <= guard && i <= k && keep[k - i]; i++) keep[k - i] = 0;
  }
}

/* sums over the scored samples */
typedef struct sums {
  double residual, measured, reversal;
  size_t scored, left_out;
} sums;

/* one segment: to the grid, through the filter, masked, summed */
static void score_segment(const tl_score_settings *s, const tl_lowpass *f, const double *t_s,
                          const double *const series[3], size_t n, double step_s, double *work, sums *sum) {
  size_t m = tl_grid_count(t_s[0], t_s[n - 1], step_s), trim = (size_t)(s->trim_s / step_s), k;
  double *y = work, *e = work + m, *speed = e + m;
  uint8_t *keep = (uint8_t *)(speed + m);

  if ((double)m * step_s < 3.0 * s->trim_s || m < 1) return;
  tl_grid_resample(t_s, series[0], n, t_s[0], step_s, y, m);
  tl_grid_resample(t_s, series[1], n, t_s[0], step_s, e, m);
  tl_grid_resample(t_s, series[2], n, t_s[0], step_s, speed, m);
  for (k = 0; k < m; k++) e[k] = y[k] - e[k];
  tl_lowpass_zero_phase(f, y, m);
  tl_lowpass_zero_phase(f, e, m);
  tl_score_keep(s, speed, m, step_s, keep);
  for (k = trim; k + trim < m; k++) {
    if (keep[k]) {
      sum->residual += e[k] * e[k];
      sum->measured += y[k] * y[k];
      sum->scored++;
    } else {
      sum->reversal += e[k] * e[k];
      sum->left_out++;
    }
  }
}

size_t tl_score_workspace(size_t n) {
  /* three series and a mask on the longest grid: no step within a segment exceeds five median steps */
  return 4 * ((size_t)TL_GAP_STEPS * n + 2);
}

tl_status tl_score(const tl_score_settings *s, const double *t_s, const uint8_t *valid,
                   const double *measured, const double *predicted, const double *speed, size_t n,
                   double *work, size_t work_n, tl_score_result *out) {
  size_t cursor = 0;
  tl_segment part;
  sums sum = {0.0, 0.0, 0.0, 0, 0};
  tl_lowpass f;
  double step_s;
  tl_status status;

  if (!s || !t_s || !measured || !predicted || !speed || !work || !out) return TL_ERR_ARGUMENT;
  if (n < TL_SEGMENT_MIN_ROWS) return TL_ERR_TOO_SHORT;
  if (work_n < tl_score_workspace(n)) return TL_ERR_WORKSPACE;
  step_s = tl_median_step(t_s, n, work);
  status = tl_lowpass_init(&f, s->order, s->lowpass_hz, step_s);
  if (status != TL_OK) return status;
  while (tl_segment_next(t_s, valid, n, step_s, &cursor, &part)) {
    const double *series[3] = {measured + part.begin, predicted + part.begin, speed + part.begin};
    score_segment(s, &f, t_s + part.begin, series, part.end - part.begin, step_s, work, &sum);
  }
  if (sum.scored == 0) return TL_ERR_TOO_SHORT;
  out->residual_rms = sqrt(sum.residual / (double)sum.scored);
  out->measured_rms = sqrt(sum.measured / (double)sum.scored);
  out->relative_percent = sum.measured > 0.0 ? 100.0 * sqrt(sum.residual / sum.measured) : 0.0;
  out->reversal_rms = sum.left_out ? sqrt(sum.reversal / (double)sum.left_out) : 0.0;
  out->scored = sum.scored;
  out->left_out = sum.left_out;
  return TL_OK;
}
