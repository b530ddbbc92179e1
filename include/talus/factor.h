/* factor.h: least squares by a small triangular factor, streamed.
 *
 * Rows (x_1 .. x_p | z) are folded into an upper triangle R of p + 1 columns by
 * Householder reflections, block after block; whatever the number of rows, the
 * cost |X b - z|^2 is afterwards that of p (p + 1) / 2 products. Unlike a Gram
 * matrix it keeps all digits near a noise-free optimum.
 *
 *     double rows_cm[] = {1, 1, 1, 0, 1, 2, 5, 7, 9}; // three rows, column after column: 1, x, z = 5 + 2 x
 *     double b[2];
 *     tl_factor f;
 *     if (tl_factor_init(&f, 2) != TL_OK) return 1;
 *     tl_factor_add(&f, rows_cm, 3, 3); // as many such blocks as there are
 *     if (tl_factor_solve(&f, 1e-12, b, NULL) != TL_OK) return 1;
 *     printf("%.1f %.1f\n", b[0], b[1]); // prints 5.0 2.0
 */
#ifndef TALUS_FACTOR_H
#define TALUS_FACTOR_H

#include <stddef.h>

#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_FACTOR_MAX 32 /* columns, without the right-hand side */

/* R row after row, see tl_factor_row; column p is the right-hand side. The diagonal is never negative; entries below it
 * are not used. */
#define TL_FACTOR_STRIDE (TL_FACTOR_MAX + 1)
typedef struct tl_factor {
  int columns; /* p */
  size_t rows; /* how many were added */
  double r[TL_FACTOR_STRIDE * TL_FACTOR_STRIDE];
} tl_factor;

/* Empty factor of `columns` 1..TL_FACTOR_MAX. */
TL_CHECK tl_status tl_factor_init(tl_factor *f, int columns);
/* Fold n rows in, column-major: column j at rows_cm + j * stride, j = 0..p (the
 * last is the right-hand side). The block is overwritten. stride >= n. Sizes up
 * to 1e150 do not overflow; a NaN or infinity shows in tl_factor_solve. */
void tl_factor_add(tl_factor *f, double *rows_cm, size_t n, size_t stride);
/* Row i of R: entries i to columns count, the last of them the right-hand side's. */
const double *tl_factor_row(const tl_factor *f, int i);
/* |column j of X|, j = columns: |z|. */
double tl_factor_column_length(const tl_factor *f, int j);
/* Fold another factor in, its rows multiplied by `weight` (its cost by weight
 * squared) and its columns mapped: its column j becomes column index[j] of f. */
void tl_factor_merge(tl_factor *f, const tl_factor *other, const int *index, double weight);
/* |X b - z|^2 over all rows, and the part of it that depends on b: what it
 * exceeds its least possible value by, with full relative precision. A search
 * should minimise the excess; the rest is r_pp^2. */
double tl_factor_cost(const tl_factor *f, const double *b);
double tl_factor_excess(const tl_factor *f, const double *b);
/* Least-squares b of minimum norm (columns scaled to unit length first);
 * directions whose singular value is below tolerance times the largest are
 * left at 0. *rank is the number kept. TL_ERR_NOT_FINITE when a row was not.
 * Nullable: rank. */
TL_CHECK tl_status tl_factor_solve(const tl_factor *f, double tolerance, double *b, int *rank);
/* (X'X)^-1 on the kept directions (0 elsewhere), row-major p x p. */
TL_CHECK tl_status tl_factor_covariance(const tl_factor *f, double tolerance, double *covariance);

/* Singular values (falling) and right singular vectors of a dense m x n
 * matrix, m >= n, row-major, by one-sided Jacobi rotations (Hestenes 1958).
 * `a` becomes U S; vector k is v[j * n + k]. Deterministic. TL_ERR_NOT_FINITE
 * leaves all untouched, TL_ERR_NO_CONVERGENCE (after 60 sweeps) the best so far. */
TL_CHECK tl_status tl_svd(double *a, int m, int n, double *singular, double *v);

#ifdef __cplusplus
}
#endif
#endif
