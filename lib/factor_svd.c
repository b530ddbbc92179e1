/* factor_svd.c: singular values by one-sided Jacobi rotations (Hestenes 1958). */
#include <float.h>
#include <math.h>

#include "math_inline.h"
#include "talus/factor.h"

/* Rotations of small matrices settle in 6 to 10 sweeps. */
#define SWEEPS_MAX 60
#define DOUBTFUL_MAX 8 /* sweeps for columns that may be nothing but rounding */

enum { DOUBTFUL = 1, TURNED = 2 };

/* dot product of columns p and q of a row-major m x n matrix */
static double column_dot(const double *a, int m, int n, int p, int q) {
  double sum = 0.0;
  for (int i = 0; i < m; i++) {
    sum += a[tl_entry(n, i, p)] * a[tl_entry(n, i, q)];
  }
  return sum;
}

/* (column p, column q) <- (c p - s q, s p + c q) */
static void rotate_columns(double *a, int m, int n, int p, int q, double c, double s) {
  for (int i = 0; i < m; i++) {
    double x = a[tl_entry(n, i, p)], y = a[tl_entry(n, i, q)];
    a[tl_entry(n, i, p)] = c * x - s * y;
    a[tl_entry(n, i, q)] = s * x + c * y;
  }
}

/* Make columns p and q orthogonal; 0 when they are so already, TURNED, or DOUBTFUL: of a singular
 * matrix rounding leaves columns without a direction, which turn for ever (its largest entry
 * is about 1 here). The smaller of the two angles is taken: t = tan of it solves
 * t^2 + 2 zeta t - 1 = 0. */
static int orthogonalise(double *a, int m, int n, double *v, int p, int q) {
  double pp = column_dot(a, m, n, p, p);
  double qq = column_dot(a, m, n, q, q);
  double pq = column_dot(a, m, n, p, q);
  double least = (double)m * 0x1p-52;
  if (fabs(pq) <= least * sqrt(pp) * sqrt(qq)) {
    return 0;
  }
  double zeta = (qq - pp) / (2.0 * pq);
  double t = (zeta < 0.0 ? -1.0 : 1.0) / (fabs(zeta) + sqrt(1.0 + zeta * zeta));
  double c = 1.0 / sqrt(1.0 + t * t);
  rotate_columns(a, m, n, p, q, c, c * t);
  rotate_columns(v, n, n, p, q, c, c * t);
  return pp <= least * least || qq <= least * least ? DOUBTFUL : TURNED;
}

/* the most that any pair needed */
static int sweep(double *a, int m, int n, double *v) {
  int most = 0;
  for (int p = 0; p + 1 < n; p++) {
    for (int q = p + 1; q < n; q++) {
      int done = orthogonalise(a, m, n, v, p, q);
      most = done > most ? done : most;
    }
  }
  return most;
}

/* The power of two next below the largest |a_i|, 0 for zeros, NaN when one is not finite. */
static double size_of(const double *a, int count) {
  double largest = 0.0;
  for (int i = 0; i < count; i++) {
    double size = fabs(a[i]);
    if (!(size <= DBL_MAX)) {
      return size - size;
    }
    largest = size > largest ? size : largest;
  }
  return tl_of_bits(tl_bits_of(largest) & 0x7ff0000000000000u);
}

static void scale_all(double *a, int count, double factor) {
  for (int i = 0; i < count; i++) {
    a[i] *= factor;
  }
}

static void set_identity(double *v, int n) {
  for (int i = 0; i < n * n; i++) {
    v[i] = i % (n + 1) == 0 ? 1.0 : 0.0;
  }
}

static void exchange_columns(double *a, int m, int n, int p, int q) {
  for (int i = 0; i < m; i++) {
    double x = a[tl_entry(n, i, p)];
    a[tl_entry(n, i, p)] = a[tl_entry(n, i, q)];
    a[tl_entry(n, i, q)] = x;
  }
}

/* singular values are the lengths of the orthogonal columns; largest first */
static void sort_columns(double *a, int m, int n, double *singular, double *v) {
  for (int k = 0; k < n; k++) {
    singular[k] = sqrt(column_dot(a, m, n, k, k));
  }
  for (int k = 0; k < n; k++) {
    int largest = k;
    for (int j = k + 1; j < n; j++) {
      largest = singular[j] > singular[largest] ? j : largest;
    }
    double s = singular[k];
    singular[k] = singular[largest];
    singular[largest] = s;
    if (largest != k) {
      exchange_columns(a, m, n, k, largest);
      exchange_columns(v, n, n, k, largest);
    }
  }
}

tl_status tl_svd(double *a, int m, int n, double *singular, double *v) {
  if (!a || !singular || !v || n < 1 || m < n) {
    return TL_ERR_ARGUMENT;
  }
  double size = size_of(a, m * n);
  if (!(size >= 0.0)) {
    return TL_ERR_NOT_FINITE;
  }
  /* squares must neither overflow nor vanish; powers of two round nothing */
  double unit = size > 0.0 ? size : 1.0;
  scale_all(a, m * n, 1.0 / unit);
  set_identity(v, n);
  int left = TURNED, doubtful = 0;
  for (int i = 0; i < SWEEPS_MAX && left > 0 && doubtful < DOUBTFUL_MAX; i++) {
    left = sweep(a, m, n, v);
    doubtful += left == DOUBTFUL;
  }
  sort_columns(a, m, n, singular, v);
  scale_all(a, m * n, unit);
  scale_all(singular, n, unit);
  return left == TURNED ? TL_ERR_NO_CONVERGENCE : TL_OK;
}
