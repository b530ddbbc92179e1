/* identify_readings.c: how far off the parameters are for what residuals do not show; see talus/identify.h.
 *
 * Every reading of the recordings has least squares of its own; what its answer differs by, d, is taken through the
 * problem's null space to the parameters. Variances add up: of
 *   - the roundings' spread over where their steps lie, over TL_ROUNDING_VARIANCE: the random part of the angles' noise,
 *     also where the motion repeats and the rounding errors with it;
 *   - what the angles' noise takes from the parameters (attenuation, Fuller 1987, ch. 1.2). With R'R = X'X as recorded and
 *     the roundings' mean X'X = R'(I + TL_ROUNDING_VARIANCE V diag(n) V')R, X'X without noise would be R'(I - V diag(n) V')R,
 *     and the component of R b along v_k would be 1 / (1 - n_k) of what it is (Cook and Stefanski 1994, by moments);
 *   - d of the longer windows and d of the thinned recordings, whole: an error that grows at least in proportion to the
 *     length of a window is at most 1 / (TL_LONGER_WINDOW - 1) = 2 times that d, and to the step at most d.
 */
#include <math.h>
#include <string.h>

#include "identify_internal.h"
#include "math_inline.h"

#define SAME_DIRECTION 1e-10      /* a pivot below this share of its column: the data do not see it apart */
#define GOLDEN 0.6180339887498949 /* places of two joints' steps that never meet */

/* where noise is half of what is seen of a direction, the other half is no measure of the motion any more */
#define HIDDEN 0.5
/* Attenuation is a ratio: of an inertia that lies within three of its systematic deviations of 0, the true value has no upper
 * bound (Fieller 1954). */
#define CLEAR_OF_ZERO 3.0

void tl_round_angles(double *x, size_t n, double noise, int number, int joint) {
  double step = noise * sqrt(12.0 * TL_ROUNDING_VARIANCE), place, origin;
  size_t i;

  if (!(step > 0.0)) return;
  place = ((double)number + 0.5) / TL_ROUNDINGS + GOLDEN * (double)joint;
  origin = step * (place - floor(place));
  for (i = 0; i < n; i++) x[i] = floor((x[i] - origin) / step + 0.5) * step + origin;
}

size_t tl_reading_place_rows(size_t rows, size_t all) {
  double fair = (double)TL_READING_ROWS / TL_READING_PLACES * (double)rows / (double)all;

  return fair < 2.0 ? 2 : (size_t)(0.5 * fair) * 2;
}

size_t tl_reading_place(size_t rows, size_t place_rows, size_t k) {
  return place_rows < rows ? (rows - place_rows) * k / (TL_READING_PLACES - 1) : 0;
}

/* ---- the sum of variances ------------------------------------------------- */

typedef struct tally {
  const tl_problem *problem;
  tl_gain gain;
  double parameter[TL_MAX_PARAMETERS], base[TL_MAX_BASE]; /* variances so far */
} tally;

/* sum of one row of a gain times x */
static double along(const double *gain, int bases, int row, const double *x) {
  double sum = 0.0;
  int b;

  for (b = 0; b < bases; b++) sum += gain[tl_entry(bases, row, b)] * x[b];
  return sum;
}

/* X'X d of the problem's own rows, from R twice */
static void normal_times(const tl_factor *f, const double *d, double *out) {
  int i, j;

  memset(out, 0, sizeof(double) * TL_MAX_BASE);
  for (i = 0; i < f->columns; i++) {
    const double *row = tl_factor_row(f, i);
    double r = 0.0;
    for (j = i; j < f->columns; j++) r += row[j] * d[j];
    for (j = i; j < f->columns; j++) out[j] += row[j] * r;
  }
}

/* share times the square of what a change d of the base parameters changes */
static void add_change(tally *t, const double *d, double share) {
  double moved[TL_MAX_BASE], change;
  int i;

  normal_times(&t->problem->factor, d, moved);
  for (i = 0; i < t->problem->parameters; i++) {
    change = along(t->gain.parameter, t->problem->bases, i, moved);
    t->parameter[i] += share * change * change;
  }
  for (i = 0; i < t->problem->bases; i++) {
    change = along(t->gain.base, t->problem->bases, i, moved);
    t->base[i] += share * change * change;
  }
}

/* least squares of a reading, less `from` */
static tl_status difference(const tl_factor *f, const double *from, int bases, double *d) {
  tl_status status = tl_factor_solve(f, SAME_DIRECTION, d, NULL);
  int i;

  for (i = 0; status == TL_OK && from && i < bases; i++) d[i] -= from[i];
  return status;
}

static tl_status add_spread(tally *t, const tl_readings *r) {
  double b[TL_ROUNDINGS][TL_FACTOR_MAX], mean[TL_MAX_BASE] = {0};
  int k, i, bases = t->problem->bases;
  tl_status status = TL_OK;

  for (k = 0; k < TL_ROUNDINGS && status == TL_OK; k++) {
    status = difference(&r->rounded[k], NULL, bases, b[k]);
    for (i = 0; i < bases; i++) mean[i] += b[k][i] / TL_ROUNDINGS;
  }
  for (k = 0; k < TL_ROUNDINGS && status == TL_OK; k++) {
    for (i = 0; i < bases; i++) b[k][i] -= mean[i];
    add_change(t, b[k], 1.0 / (TL_ROUNDING_VARIANCE * (TL_ROUNDINGS - 1)));
  }
  return status;
}

/* ---- attenuation ----------------------------------------------------------- */

/* a direction that noise and motion share: of base parameters, c = R^-1 v (v'R b), and noise's part in it */
typedef struct direction {
  double c[TL_MAX_BASE], noise;
} direction;

static int is_seen(const tl_factor *f, int i) {
  return tl_factor_row(f, i)[i] > SAME_DIRECTION * tl_factor_column_length(f, i);
}

/* x = R^-1 x; what the data do not see apart becomes 0 */
static void solve_back(const tl_factor *f, double *x) {
  int i, j;

  for (i = f->columns - 1; i >= 0; i--) {
    const double *row = tl_factor_row(f, i);
    for (j = i + 1; j < f->columns; j++) x[i] -= row[j] * x[j];
    x[i] = is_seen(f, i) ? x[i] / row[i] : 0.0;
  }
}

/* M of M R = Q, row-major, column after column; 0 for columns that R does not see */
static void ratio_matrix(const tl_factor *q, const tl_factor *f, double *matrix) {
  int p = f->columns, i, j, k;

  for (i = 0; i < p; i++)
    for (j = 0; j < p; j++) {
      double sum = j >= i ? tl_factor_row(q, i)[j] : 0.0;
      for (k = 0; k < j; k++) sum -= matrix[tl_entry(p, i, k)] * tl_factor_row(f, k)[j];
      matrix[tl_entry(p, i, j)] = is_seen(f, j) ? sum / tl_factor_row(f, j)[j] : 0.0;
    }
}

/* the mean of the rounded readings at as many rows as were recorded */
static tl_status mean_of_rounded(const tl_readings *r, tl_factor *mean) {
  int i, k, same[TL_MAX_BASE];
  tl_status status = tl_factor_init(mean, r->as_recorded.columns);

  for (i = 0; i < TL_MAX_BASE; i++) same[i] = i;
  for (k = 0; k < TL_ROUNDINGS && status == TL_OK; k++)
    tl_factor_merge(mean, &r->rounded[k], same,
                    sqrt((double)r->as_recorded.rows / ((double)r->rounded[k].rows * TL_ROUNDINGS)));
  return status;
}

tl_status tl_reading_share(const tl_problem *problem, const tl_factor *reading, double *share) {
  double matrix[TL_MAX_BASE * TL_MAX_BASE], singular[TL_MAX_BASE], v[TL_MAX_BASE * TL_MAX_BASE];
  int p, i, seen = 0;
  tl_status status;

  if (!problem || !reading || !share || reading->columns != problem->bases) return TL_ERR_ARGUMENT;
  p = problem->bases;
  *share = 0.0;
  if (reading->rows == 0) return TL_OK;
  ratio_matrix(reading, &problem->factor, matrix);
  status = tl_svd(matrix, p, p, singular, v);
  if (status != TL_OK) return status;
  for (i = 0; i < p; i++) seen += is_seen(&problem->factor, i);
  if (seen > 0)
    *share = singular[seen - 1] * singular[seen - 1] * (double)problem->factor.rows / (double)reading->rows;
  return TL_OK;
}

static tl_status directions(const tl_readings *r, const double *b, direction *out) {
  const tl_factor *f = &r->as_recorded;
  double matrix[TL_MAX_BASE * TL_MAX_BASE], singular[TL_MAX_BASE], v[TL_MAX_BASE * TL_MAX_BASE];
  int p = f->columns, i, j, k;
  tl_factor mean;
  tl_status status = mean_of_rounded(r, &mean);

  if (status == TL_OK) ratio_matrix(&mean, f, matrix);
  if (status == TL_OK) status = tl_svd(matrix, p, p, singular, v);
  for (k = 0; k < p && status == TL_OK; k++) {
    double component = 0.0;
    for (i = 0; i < p; i++)
      for (j = i; j < p; j++) component += v[tl_entry(p, i, k)] * tl_factor_row(f, i)[j] * b[j];
    for (i = 0; i < p; i++) out[k].c[i] = component * v[tl_entry(p, i, k)];
    solve_back(f, out[k].c);
    out[k].noise = (singular[k] * singular[k] - 1.0) / TL_ROUNDING_VARIANCE;
    if (!(singular[k] > 0.0)) out[k].noise = 0.0; /* a column that the data do not see apart */
  }
  return status;
}

/* what all directions together lack */
static void add_attenuation(tally *t, const direction *all) {
  double lacking[TL_MAX_BASE] = {0};
  int i, k;

  for (k = 0; k < t->problem->bases; k++)
    for (i = 0; i < t->problem->bases && all[k].noise < HIDDEN; i++)
      lacking[i] += all[k].c[i] * all[k].noise / (1.0 - all[k].noise);
  add_change(t, lacking, 1.0);
}

/* parameters of which more than a standard deviation stands in a direction that noise hides */
static void mark_hidden(const tally *t, const direction *all, tl_identify_result *result) {
  double moved[TL_MAX_BASE];
  int i, k, bases = t->problem->bases;

  for (k = 0; k < bases; k++) {
    if (all[k].noise < HIDDEN) continue;
    normal_times(&t->problem->factor, all[k].c, moved);
    for (i = 0; i < t->problem->parameters; i++)
      if (fabs(along(t->gain.parameter, bases, i, moved)) > result->sigma[i]) result->hidden[i] = 1;
    for (i = 0; i < bases; i++)
      if (fabs(along(t->gain.base, bases, i, moved)) > result->base_sigma[i])
        result->base_sigma[i] = (double)NAN;
  }
}

/* inertias that might as well be 0 */
static void mark_unclear(const tl_problem *p, tl_identify_result *result) {
  int i, n;
  const tl_parameter *table = tl_parameters(&p->model, &n);

  for (i = 0; i < n; i++)
    if (table[i].positive && result->value[i] < CLEAR_OF_ZERO * result->systematic[i]) result->hidden[i] = 1;
  for (i = 0; i < n; i++) {
    if (!result->identifiable[i]) result->hidden[i] = 0;
    if (result->hidden[i]) result->sigma[i] = (double)NAN;
  }
}

/* ---- all of it -------------------------------------------------------------- */

/* rows as they were recorded, and readings of the problem's columns? */
static int are_readings(const tl_readings *r, int bases) {
  int k, all = r->as_recorded.rows > 0 && r->as_recorded.columns == bases;

  for (k = 0; k < TL_ROUNDINGS; k++) all &= r->rounded[k].columns == bases;
  return all;
}

/* are there rounded readings in which nothing moves any more? */
static int is_rounded_away(const tl_readings *r) {
  int k, away = 0;

  for (k = 0; k < TL_ROUNDINGS; k++) away |= r->rounded[k].rows == 0;
  return away;
}

/* noise that hides the whole motion hides every parameter: each is as far off as it is large */
static void hide_all(const tl_problem *p, tl_identify_result *result) {
  int i;

  for (i = 0; i < p->parameters; i++) {
    result->systematic[i] = fabs(result->value[i]);
    result->hidden[i] = result->identifiable[i];
    if (result->hidden[i]) result->sigma[i] = (double)NAN;
  }
  for (i = 0; i < p->bases; i++) {
    result->base_systematic[i] = fabs(result->base[i]);
    result->base_sigma[i] = (double)NAN;
  }
}

static void widen(const tally *t, tl_identify_result *result) {
  int i;

  for (i = 0; i < t->problem->parameters; i++) {
    result->systematic[i] = sqrt(t->parameter[i]);
    result->sigma[i] = sqrt(result->sigma[i] * result->sigma[i] + t->parameter[i]);
  }
  for (i = 0; i < t->problem->bases; i++) {
    result->base_systematic[i] = sqrt(t->base[i]);
    result->base_sigma[i] = sqrt(result->base_sigma[i] * result->base_sigma[i] + t->base[i]);
  }
}

tl_status tl_identify_readings(const tl_problem *problem, const tl_readings *readings,
                               tl_identify_result *result) {
  const tl_factor *other[2];
  direction all[TL_MAX_BASE] = {{{0}, 0}};
  double b[TL_FACTOR_MAX], d[TL_FACTOR_MAX];
  tally t = {problem, {{0}, {0}, 0}, {0}, {0}};
  int k;
  tl_status status;

  if (!problem || !readings || !result || !are_readings(readings, problem->bases)) return TL_ERR_ARGUMENT;
  if (is_rounded_away(readings)) {
    hide_all(problem, result);
    return TL_OK;
  }
  status = tl_identify_gain(problem, result->value, &t.gain);
  if (status == TL_OK) status = difference(&readings->as_recorded, NULL, problem->bases, b);
  if (status == TL_OK) status = add_spread(&t, readings);
  if (status == TL_OK) status = directions(readings, b, all);
  if (status != TL_OK) return status;
  add_attenuation(&t, all);
  other[0] = &readings->longer;
  other[1] = &readings->thinned;
  for (k = 0; k < 2; k++) {
    if (other[k]->rows == 0) continue;
    status = difference(other[k], b, problem->bases, d);
    if (status != TL_OK) return status;
    add_change(&t, d, 1.0);
  }
  widen(&t, result);
  mark_hidden(&t, all, result);
  mark_unclear(problem, result);
  return TL_OK;
}
