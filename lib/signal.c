/* signal.c: see talus/signal.h. */
#include "talus/signal.h"

#include <math.h>
#include <string.h>

#define EVEN 1e-6      /* steps that agree to this share of a step count as even */
#define LEAST_RUN 4    /* outputs with even windows from which on a common kernel is made */
#define TAPS 5         /* weights that are taken together */
#define BLOCK_ROWS 128 /* outputs that pass a kernel together */
#define FIT_ARRAYS 3   /* arrays of one value a sample that tl_window_fit needs */

size_t tl_reconstruct_workspace(size_t samples) {
  return FIT_ARRAYS * samples + 3 * samples;
}

/* One step of Forsythe's recurrence: p[] becomes the next polynomial that is
 * orthogonal on the nodes u[], previous[] the one before it; value[] follows at the
 * point 0 with its first two derivatives. norm[] carries <p, p> of both. */
typedef struct basis {
  size_t n;
  double *u, *p, *previous;
  double norm, previous_norm;
  double value[3], previous_value[3];
} basis;

static double dot(const double *a, const double *b, size_t n) {
  double s0 = 0.0, s1 = 0.0;
  size_t i;

  for (i = 0; i + 1 < n; i += 2) {
    s0 += a[i] * b[i];
    s1 += a[i + 1] * b[i + 1];
  }
  if (i < n) s0 += a[i] * b[i];
  return s0 + s1;
}

/* the constant polynomial on nodes (t - at) / scale */
static void basis_begin(basis *b, const double *t_s, size_t n, double at_s, double scale, double *work) {
  size_t i;

  b->n = n;
  b->u = work;
  b->p = work + n;
  b->previous = work + 2 * n;
  for (i = 0; i < n; i++) {
    b->u[i] = (t_s[i] - at_s) / scale;
    b->p[i] = 1.0;
    b->previous[i] = 0.0;
  }
  b->norm = (double)n;
  b->previous_norm = 1.0;
  b->value[0] = 1.0;
  b->value[1] = b->value[2] = 0.0;
  memset(b->previous_value, 0, sizeof b->previous_value);
}

static void basis_next(basis *b, int first) {
  double alpha = 0.0, beta = first ? 0.0 : b->norm / b->previous_norm, next[3], *swap;
  size_t i;

  for (i = 0; i < b->n; i++) alpha += b->u[i] * b->p[i] * b->p[i];
  alpha /= b->norm;
  for (i = 0; i < b->n; i++) b->previous[i] = (b->u[i] - alpha) * b->p[i] - beta * b->previous[i];
  swap = b->p;
  b->p = b->previous;
  b->previous = swap;
  next[0] = -alpha * b->value[0] - beta * b->previous_value[0];
  next[1] = b->value[0] - alpha * b->value[1] - beta * b->previous_value[1];
  next[2] = 2.0 * b->value[1] - alpha * b->value[2] - beta * b->previous_value[2];
  memcpy(b->previous_value, b->value, sizeof next);
  memcpy(b->value, next, sizeof next);
  b->previous_norm = b->norm;
  b->norm = dot(b->p, b->p, b->n);
}

/* the nodes' scale: half the window's length, so that they lie about [-1, 1] */
static double node_scale(const double *t_s, size_t n) {
  double half = 0.5 * (t_s[n - 1] - t_s[0]);
  return half > 0.0 ? half : 1.0;
}

tl_status tl_window_fit(const double *t_s, const double *x, size_t n, double at_s, int order, double *work,
                        double out[3]) {
  double sum[3] = {0.0, 0.0, 0.0}, scale;
  basis b;
  int k, d;

  if (!t_s || !x || !work || !out || order < 0) return TL_ERR_ARGUMENT;
  if (n <= (size_t)order) return TL_ERR_TOO_SHORT;
  scale = node_scale(t_s, n);
  basis_begin(&b, t_s, n, at_s, scale, work);
  for (k = 0;; k++) {
    double c = dot(x, b.p, n) / b.norm;
    for (d = 0; d < 3; d++) sum[d] += c * b.value[d];
    if (k == order) break;
    basis_next(&b, k == 0);
  }
  out[0] = sum[0];
  out[1] = sum[1] / scale;
  out[2] = sum[2] / (scale * scale);
  return TL_OK;
}

tl_status tl_window_weights(const double *t_s, size_t n, double at_s, int order, double *work,
                            double *weight) {
  double scale, unit[3];
  basis b;
  size_t i;
  int k, d;

  if (!t_s || !work || !weight || order < 0) return TL_ERR_ARGUMENT;
  if (n <= (size_t)order) return TL_ERR_TOO_SHORT;
  scale = node_scale(t_s, n);
  unit[0] = 1.0;
  unit[1] = 1.0 / scale;
  unit[2] = unit[1] / scale;
  basis_begin(&b, t_s, n, at_s, scale, work);
  memset(weight, 0, 3 * n * sizeof *weight);
  for (k = 0;; k++) {
    for (d = 0; d < 3; d++) {
      double c = b.value[d] / b.norm * unit[d];
      for (i = 0; i < n; i++) weight[(size_t)d * n + i] += c * b.p[i];
    }
    if (k == order) break;
    basis_next(&b, k == 0);
  }
  return TL_OK;
}

/* ---- sliding ----------------------------------------------------------- */

/* what one call of tl_reconstruct works on */
typedef struct sliding {
  const tl_window *w;
  const double *t_s, *x;
  size_t n;
  double *out[3];
  double *work;
  size_t room; /* samples that the workspace holds */
} sliding;

/* Rows [*first, *last) of the window at row i: within half a length of its
 * time, moved inside at the ends, never fewer than order + 1. The bounds only move
 * forward from one row to the next. */
static void window_rows(const sliding *s, size_t i, size_t *first, size_t *last) {
  double edge = 0.5 * s->w->length_s, half = edge * (1.0 + 1e-9), at = s->t_s[i];
  double low = s->t_s[0] + edge, high = s->t_s[s->n - 1] - edge;
  size_t least = (size_t)s->w->order + 1;

  at = at > high ? high : at;
  at = at < low ? low : at;
  while (*first + 1 < s->n && s->t_s[*first] < at - half) (*first)++;
  *last = *last < *first ? *first : *last;
  while (*last < s->n && s->t_s[*last] <= at + half) (*last)++;
  while (*last - *first < least) {
    /* too few: take the nearer neighbour */
    int left = *first > 0 && (*last == s->n || at - s->t_s[*first - 1] <= s->t_s[*last] - at);
    if (left)
      (*first)--;
    else
      (*last)++;
  }
}

static void store(const sliding *s, size_t i, const double value[3]) {
  int d;

  for (d = 0; d < 3; d++)
    if (s->out[d]) s->out[d][i] = value[d];
}

/* the window at row i, by its own fit at the true times */
static tl_status fit_row(const sliding *s, size_t i, size_t *first, size_t *last) {
  double value[3];
  tl_status status;

  window_rows(s, i, first, last);
  if (*last - *first > s->room) return TL_ERR_WORKSPACE;
  status =
      tl_window_fit(s->t_s + *first, s->x + *first, *last - *first, s->t_s[i], s->w->order, s->work, value);
  if (status == TL_OK) store(s, i, value);
  return status;
}

/* three sums for each of n outputs, in the first-level cache while the kernel's weights pass */
typedef struct even_sums {
  double value[BLOCK_ROWS], first[BLOCK_ROWS], second[BLOCK_ROWS];
} even_sums;

/* `taps` weights of a symmetric kernel from j on, on both sides of n outputs at x: value and second derivative
 * have even weights, the first derivative odd ones. With `taps` a constant the loop over outputs runs in vector
 * registers, and the sums are fetched and put back once. */
static inline void add_taps(even_sums *restrict a, const double *restrict x, const double *const w[3],
                            size_t j, size_t taps, size_t n) {
  const double *restrict right = x + j, *restrict left = x - j;
  const double *restrict v = w[0] + j, *restrict f = w[1] + j, *restrict s = w[2] + j;
  size_t l, k;

  for (l = 0; l < n; l++) {
    double value = a->value[l], first = a->first[l], second = a->second[l];
    for (k = 0; k < taps; k++) {
      double sum = right[l + k] + left[l - k], difference = right[l + k] - left[l - k];
      value += v[k] * sum;
      first += f[k] * difference;
      second += s[k] * sum;
    }
    a->value[l] = value;
    a->first[l] = first;
    a->second[l] = second;
  }
}

/* outputs [i, i + n) by a symmetric kernel of 2 half + 1 weights, n <= BLOCK_ROWS */
static void even_block(const sliding *s, const double *weight, size_t half, size_t i, size_t n) {
  const size_t count = 2 * half + 1;
  const double *const w[3] = {weight + half, weight + count + half, weight + 2 * count + half};
  const double *x = s->x + i;
  even_sums a;
  size_t j, l;

  for (l = 0; l < n; l++) {
    a.value[l] = w[0][0] * x[l];
    a.first[l] = 0.0;
    a.second[l] = w[2][0] * x[l];
  }
  for (j = 1; j + TAPS <= half + 1; j += TAPS) add_taps(&a, x, w, j, TAPS, n);
  for (; j + 1 <= half; j += 2) add_taps(&a, x, w, j, 2, n);
  if (j == half) add_taps(&a, x, w, j, 1, n);
  if (s->out[0]) memcpy(s->out[0] + i, a.value, n * sizeof(double));
  if (s->out[1]) memcpy(s->out[1] + i, a.first, n * sizeof(double));
  if (s->out[2]) memcpy(s->out[2] + i, a.second, n * sizeof(double));
}

/* rows [begin, end) whose windows of `half` samples to each side are even */
static void even_rows(const sliding *s, size_t begin, size_t end, size_t half) {
  size_t count = 2 * half + 1, i;
  double *weight = s->work + FIT_ARRAYS * count;

  if (tl_window_weights(s->t_s + begin - half, count, s->t_s[begin], s->w->order, s->work, weight) != TL_OK)
    return;
  for (i = begin; i < end; i += BLOCK_ROWS)
    even_block(s, weight, half, i, end - i < BLOCK_ROWS ? end - i : BLOCK_ROWS);
}

/* end of the run of even steps that begins at row i */
static size_t even_run(const sliding *s, size_t i) {
  double step = i + 1 < s->n ? s->t_s[i + 1] - s->t_s[i] : 0.0;
  size_t j = i + 1;

  while (j < s->n && fabs(s->t_s[j] - s->t_s[i] - (double)(j - i) * step) <= EVEN * step) j++;
  return j;
}

/* samples to each side of the window's centre at this step */
static size_t half_samples(const tl_window *w, double step) {
  size_t half = (size_t)(0.5 * w->length_s * (1.0 + 1e-9) / step), least = ((size_t)w->order + 1) / 2;
  return half < least ? least : half;
}

tl_status tl_reconstruct(const tl_window *w, const double *t_s, const double *x, size_t n, double *position,
                         double *velocity, double *acceleration, double *work, size_t work_n) {
  sliding s = {w, t_s, x, n, {position, velocity, acceleration}, work, work_n / tl_reconstruct_workspace(1)};
  size_t i = 0, first = 0, last = 0;

  if (!w || !t_s || !x || !work) return TL_ERR_ARGUMENT;
  if (w->order < 2 || w->order > TL_WINDOW_MAX_ORDER || !(w->length_s >= 0.0)) return TL_ERR_RANGE;
  if (n <= (size_t)w->order) return TL_ERR_TOO_SHORT;
  while (i < n) {
    size_t end = even_run(&s, i), half = end > i + 1 ? half_samples(w, t_s[i + 1] - t_s[i]) : n;
    size_t begin = i, stop = end;

    /* windows that lie wholly within the run, and off the ends of the data, take the kernel */
    if (2 * half + LEAST_RUN <= end - i && 2 * half + 1 <= s.room) {
      begin = i + half;
      stop = end - half;
      while (begin < stop && t_s[begin] < t_s[0] + 0.5 * w->length_s) begin++;
      while (begin < stop && t_s[stop - 1] > t_s[n - 1] - 0.5 * w->length_s) stop--;
    }
    if (begin == i || stop < begin + LEAST_RUN) begin = stop = end;
    for (; i < begin; i++)
      if (fit_row(&s, i, &first, &last) != TL_OK) return TL_ERR_WORKSPACE;
    if (begin < stop) even_rows(&s, begin, stop, half);
    for (i = stop; i < end; i++)
      if (fit_row(&s, i, &first, &last) != TL_OK) return TL_ERR_WORKSPACE;
  }
  return TL_OK;
}
