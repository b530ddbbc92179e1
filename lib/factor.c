/* factor.c: a triangular factor of streamed rows, and least squares from it. */
#include "talus/factor.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "math_inline.h"

/* Rows folded at a time: 256 rows of 8 columns are 16 KiB and stay in the
 * first-level cache while the columns are passed over. */
#define BLOCK_ROWS 256

static double *row_of(tl_factor *f, int i) {
  return f->r + (size_t)i * TL_FACTOR_STRIDE;
}

static const double *const_row_of(const tl_factor *f, int i) {
  return f->r + (size_t)i * TL_FACTOR_STRIDE;
}

const double *tl_factor_row(const tl_factor *f, int i) {
  return const_row_of(f, i);
}

double tl_factor_column_length(const tl_factor *f, int j) {
  double sum = 0.0;
  for (int i = 0; i <= j; i++) {
    double r = const_row_of(f, i)[j];
    sum += r * r;
  }
  return sqrt(sum);
}

tl_status tl_factor_init(tl_factor *f, int columns) {
  if (!f || columns < 1 || columns > TL_FACTOR_MAX) {
    return TL_ERR_ARGUMENT;
  }
  memset(f->r, 0, sizeof f->r);
  f->columns = columns;
  f->rows = 0;
  return TL_OK;
}

/* sum of a_i b_i in four interleaved partial sums: the order is the source's,
 * on a machine with vector registers and on one without */
static double dot(const double *restrict a, const double *restrict b, size_t n) {
  double s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0;
  size_t i = 0;
  for (; i + 4 <= n; i += 4) {
    s0 += a[i] * b[i];
    s1 += a[i + 1] * b[i + 1];
    s2 += a[i + 2] * b[i + 2];
    s3 += a[i + 3] * b[i + 3];
  }
  for (; i < n; i++) {
    s0 += a[i] * b[i];
  }
  return (s0 + s2) + (s1 + s3);
}

static void subtract_scaled(double *restrict y, const double *restrict x, double scale, size_t n) {
  for (size_t i = 0; i < n; i++) {
    y[i] -= scale * x[i];
  }
}

/* y <- y - scale x, and dot(with, y) of the result: one pass over y instead of two */
static double subtract_and_dot(double *restrict y, const double *restrict x, double scale,
                               const double *restrict with, size_t n) {
  double s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0;
  size_t i = 0;
  for (; i + 4 <= n; i += 4) {
    double y0 = y[i] - scale * x[i], y1 = y[i + 1] - scale * x[i + 1];
    double y2 = y[i + 2] - scale * x[i + 2], y3 = y[i + 3] - scale * x[i + 3];
    y[i] = y0;
    y[i + 1] = y1;
    y[i + 2] = y2;
    y[i + 3] = y3;
    s0 += with[i] * y0;
    s1 += with[i + 1] * y1;
    s2 += with[i + 2] * y2;
    s3 += with[i + 3] * y3;
  }
  for (; i < n; i++) {
    y[i] -= scale * x[i];
    s0 += with[i] * y[i];
  }
  return (s0 + s2) + (s1 + s3);
}

/* products of column k of the block with itself and all that follow */
static void dot_all(const tl_factor *f, int k, const double *block, size_t n, size_t stride,
                    double *product) {
  for (int j = k; j <= f->columns; j++) {
    product[j] = dot(block + (size_t)k * stride, block + (size_t)j * stride, n);
  }
}

/* Annihilate column k of the block against r_kk by one Householder reflection
 * of row k of R and the n new rows; rows of R below k are 0 in this column and
 * stay as they are. With x the block's column, alpha = r_kk >= 0 and
 * norm = |(alpha, x)|, the reflection that sends (alpha, x) to (-norm, 0) does
 * not cancel; row k is then negated, which keeps the diagonal positive:
 *
 *     r_kj <- rho = (alpha r_kj + x . y_j) / norm
 *     y_j  <- y_j - x (r_kj + rho) / (alpha + norm)
 *
 * product[j] comes in as x . y_j and goes out as the same for column k + 1. */
static void reflect_column(tl_factor *f, int k, double *block, size_t n, size_t stride, double *product) {
  double *r = row_of(f, k), *x = block + (size_t)k * stride;
  if (product[k] == 0.0) {
    /* a column of zeros: nothing to annihilate */
    dot_all(f, k + 1, block, n, stride, product);
    return;
  }
  double alpha = r[k], norm = sqrt(alpha * alpha + product[k]);
  double per_norm = 1.0 / norm, per_sum = 1.0 / (alpha + norm);
  r[k] = norm;
  for (int j = k + 1; j <= f->columns; j++) {
    double *y = block + (size_t)j * stride;
    double rho = (alpha * r[j] + product[j]) * per_norm, scale = (r[j] + rho) * per_sum;
    r[j] = rho;
    if (j == k + 1) {
      subtract_scaled(y, x, scale, n);
      product[j] = dot(y, y, n);
    } else {
      product[j] = subtract_and_dot(y, x, scale, x + stride, n);
    }
  }
}

void tl_factor_add(tl_factor *f, double *rows_cm, size_t n, size_t stride) {
  double product[TL_FACTOR_STRIDE];
  for (size_t first = 0; first < n; first += BLOCK_ROWS) {
    size_t count = n - first < BLOCK_ROWS ? n - first : BLOCK_ROWS;
    dot_all(f, 0, rows_cm + first, count, stride, product);
    for (int k = 0; k <= f->columns; k++) {
      reflect_column(f, k, rows_cm + first, count, stride, product);
    }
  }
  f->rows += n;
}

void tl_factor_merge(tl_factor *f, const tl_factor *other, const int *index, double weight) {
  double block[TL_FACTOR_STRIDE * TL_FACTOR_STRIDE] = {0.0};
  size_t n = (size_t)other->columns + 1;
  for (int i = 0; i <= other->columns; i++) {
    const double *r = const_row_of(other, i);
    for (int j = i; j <= other->columns; j++) {
      int column = j < other->columns ? index[j] : f->columns;
      block[(size_t)column * n + (size_t)i] += weight * r[j];
    }
  }
  size_t rows = f->rows + other->rows;
  tl_factor_add(f, block, n, n);
  f->rows = rows;
}

double tl_factor_excess(const tl_factor *f, const double *b) {
  int p = f->columns;
  double excess = 0.0;
  for (int i = 0; i < p; i++) {
    const double *r = const_row_of(f, i);
    double residual = r[p];
    for (int j = i; j < p; j++) {
      residual -= r[j] * b[j];
    }
    excess += residual * residual;
  }
  return excess;
}

double tl_factor_cost(const tl_factor *f, const double *b) {
  double least = const_row_of(f, f->columns)[f->columns];
  return tl_factor_excess(f, b) + least * least;
}

/* What the solutions are made of: R's columns scaled to length 1 and their
 * singular values. */
typedef struct decomposition {
  int rank;
  double length[TL_FACTOR_MAX];             /* of each column, 1 for a column of zeros */
  double us[TL_FACTOR_MAX * TL_FACTOR_MAX]; /* U S, (p x p) row-major */
  double v[TL_FACTOR_MAX * TL_FACTOR_MAX];
  double singular[TL_FACTOR_MAX];
} decomposition;

static tl_status decompose(decomposition *d, const tl_factor *f, double tolerance) {
  int p = f->columns;
  for (int j = 0; j < p; j++) {
    double length = tl_factor_column_length(f, j);
    d->length[j] = length > 0.0 ? length : 1.0;
    for (int i = 0; i < p; i++) {
      d->us[tl_entry(p, i, j)] = i <= j ? const_row_of(f, i)[j] / d->length[j] : 0.0;
    }
  }
  tl_status status = tl_svd(d->us, p, p, d->singular, d->v);
  d->rank = 0;
  while (status == TL_OK && d->rank < p && d->singular[d->rank] > tolerance * d->singular[0]) {
    d->rank++;
  }
  return status;
}

static int is_finite(double x) {
  return fabs(x) <= DBL_MAX;
}

static int right_side_is_finite(const tl_factor *f) {
  for (int i = 0; i <= f->columns; i++) {
    if (!is_finite(const_row_of(f, i)[f->columns])) {
      return 0;
    }
  }
  return 1;
}

/* coordinate of the right-hand side along singular direction k: (U S)_k' z / s^2 */
static double along(const decomposition *d, const tl_factor *f, int k) {
  int p = f->columns;
  double sum = 0.0;
  for (int i = 0; i < p; i++) {
    sum += d->us[tl_entry(p, i, k)] * const_row_of(f, i)[p];
  }
  return sum / d->singular[k] / d->singular[k];
}

tl_status tl_factor_solve(const tl_factor *f, double tolerance, double *b, int *rank) {
  if (!f || !b || !(tolerance >= 0.0)) {
    return TL_ERR_ARGUMENT;
  }
  if (!right_side_is_finite(f)) {
    return TL_ERR_NOT_FINITE;
  }
  decomposition d;
  tl_status status = decompose(&d, f, tolerance);
  if (status != TL_OK) {
    return status;
  }
  int p = f->columns;
  for (int j = 0; j < p; j++) {
    b[j] = 0.0;
  }
  for (int k = 0; k < d.rank; k++) {
    double coordinate = along(&d, f, k);
    for (int j = 0; j < p; j++) {
      b[j] += d.v[tl_entry(p, j, k)] * coordinate;
    }
  }
  for (int j = 0; j < p; j++) {
    b[j] /= d.length[j];
  }
  if (rank) {
    *rank = d.rank;
  }
  return TL_OK;
}

tl_status tl_factor_covariance(const tl_factor *f, double tolerance, double *covariance) {
  if (!f || !covariance || !(tolerance >= 0.0)) {
    return TL_ERR_ARGUMENT;
  }
  decomposition d;
  tl_status status = decompose(&d, f, tolerance);
  if (status != TL_OK) {
    return status;
  }
  int p = f->columns;
  for (int i = 0; i < p; i++) {
    for (int j = 0; j < p; j++) {
      double sum = 0.0;
      for (int k = 0; k < d.rank; k++) {
        sum += (d.v[tl_entry(p, i, k)] / d.singular[k]) * (d.v[tl_entry(p, j, k)] / d.singular[k]);
      }
      covariance[tl_entry(p, i, j)] = sum / (d.length[i] * d.length[j]);
    }
  }
  return TL_OK;
}
