/* identify_conclude.c: null space, nearest point, certificate, sigmas; see talus/identify.h. */
#include <math.h>
#include <string.h>

#include "identify_internal.h"
#include "math_inline.h"

#define NEAREST_STEPS 200
#define NEAREST_TOLERANCE 1e-14
#define IN_NULL_SPACE 1e-3 /* a parameter with a larger share of a null direction is not identifiable */
#define RANK_TOLERANCE 1e-10

/* The data's view of the free parameters: A = R J S, its singular values and
 * vectors; S scales, J = d base / d parameter. */
typedef struct view {
  int rows, columns;            /* bases, free parameters */
  int free_[TL_MAX_PARAMETERS]; /* column -> parameter */
  int kept;                     /* directions that the data see */
  double singular[TL_MAX_PARAMETERS];
  double u[TL_MAX_PARAMETERS * TL_MAX_PARAMETERS]; /* U S, rows x columns (padded with zero rows) */
  double v[TL_MAX_PARAMETERS * TL_MAX_PARAMETERS]; /* vector k is column k */
} view;

static int is_free(const tl_problem *p, const int *pinned, int i) {
  return p->upper[i] > p->lower[i] && !(pinned && pinned[i]);
}

/* row i of R times vector b */
static double r_row(const tl_factor *f, int i, const double *b, int stride) {
  const double *row = tl_factor_row(f, i);
  double sum = 0.0;
  int j;

  for (j = i; j < f->columns; j++) sum += row[j] * b[j * stride];
  return sum;
}

/* A = R J S over the free parameters, at the given values */
static void view_matrix(const tl_problem *p, const double *value, const int *pinned, view *w) {
  double jacobian[TL_MAX_BASE * TL_MAX_PARAMETERS];
  tl_model m = p->model;
  int i, k, n = 0;

  tl_parameters_set(&m, value);
  tl_base_jacobian(&m, jacobian);
  for (i = 0; i < p->parameters; i++)
    if (is_free(p, pinned, i)) w->free_[n++] = i;
  w->columns = n;
  w->rows = p->bases > n ? p->bases : n;
  memset(w->u, 0, sizeof w->u);
  for (k = 0; k < n; k++)
    for (i = 0; i < p->bases; i++)
      w->u[tl_entry(n, i, k)] =
          r_row(&p->factor, i, jacobian + w->free_[k], p->parameters) * p->scale[w->free_[k]];
}

static tl_status view_init(const tl_problem *p, const double *value, const int *pinned, view *w) {
  tl_status status;
  int k;

  view_matrix(p, value, pinned, w);
  if (w->columns == 0) return TL_ERR_SINGULAR;
  status = tl_svd(w->u, w->rows, w->columns, w->singular, w->v);
  if (status != TL_OK) return status;
  w->kept = 0;
  for (k = 0; k < w->columns; k++)
    if (w->singular[k] > p->settings.null_tolerance * w->singular[0]) w->kept++;
  return TL_OK;
}

/* x = pinv(A) r over the kept directions */
static void view_solve(const view *w, const double *r, double *x) {
  int i, j, k;

  memset(x, 0, (size_t)w->columns * sizeof *x);
  for (k = 0; k < w->kept; k++) {
    double c = 0.0;
    for (i = 0; i < w->rows; i++) c += w->u[tl_entry(w->columns, i, k)] * r[i];
    c /= w->singular[k] * w->singular[k];
    for (j = 0; j < w->columns; j++) x[j] += c * w->v[tl_entry(w->columns, j, k)];
  }
}

static void base_at(const tl_problem *p, const double *value, double *base) {
  tl_model m = p->model;

  tl_parameters_set(&m, value);
  tl_base_values(&m, base);
}

/* One step towards the point of the solution set nearest to the prior:
 * x <- pinv(A) (R (b* - b(x)) + A x), x the relative changes; the part of x
 * that the data cannot see becomes 0. Returns the largest change. */
static tl_status nearest_step(const tl_problem *p, const double *goal, const int *pinned, double *value,
                              double *change) {
  double base[TL_MAX_BASE], gap[TL_MAX_BASE], r[TL_MAX_PARAMETERS] = {0}, x[TL_MAX_PARAMETERS], a;
  view w;
  int i, k, j;
  tl_status status = view_init(p, value, pinned, &w);

  if (status != TL_OK) return status;
  base_at(p, value, base);
  for (i = 0; i < p->bases; i++) gap[i] = goal[i] - base[i];
  for (i = 0; i < p->bases; i++) r[i] = r_row(&p->factor, i, gap, 1);
  for (j = 0; j < w.columns; j++) x[j] = (value[w.free_[j]] - p->prior[w.free_[j]]) / p->scale[w.free_[j]];
  for (i = 0; i < w.rows; i++)
    for (k = 0; k < w.kept; k++)
      for (a = w.u[tl_entry(w.columns, i, k)], j = 0; j < w.columns; j++)
        r[i] += a * w.v[tl_entry(w.columns, j, k)] * x[j];
  view_solve(&w, r, x);
  *change = 0.0;
  for (j = 0; j < w.columns; j++) {
    double next = p->prior[w.free_[j]] + p->scale[w.free_[j]] * x[j];
    double moved = fabs(next - value[w.free_[j]]) / p->scale[w.free_[j]];
    *change = moved > *change ? moved : *change;
    value[w.free_[j]] = next;
  }
  return TL_OK;
}

/* parameters that left their bounds are pinned there: 1 when any was */
static int pin_violated(const tl_problem *p, int *pinned, double *value) {
  int i, any = 0;

  for (i = 0; i < p->parameters; i++) {
    double inside = value[i] < p->lower[i] ? p->lower[i] : value[i] > p->upper[i] ? p->upper[i] : value[i];
    if (inside == value[i]) continue;
    value[i] = inside;
    pinned[i] = any = 1;
  }
  return any;
}

/* the point nearest to the prior with the optimum's base parameters; the
 * swarm's own point where the iteration does not settle */
static tl_status nearest_point(const tl_problem *p, const double *best, double *value) {
  int pinned[TL_MAX_PARAMETERS] = {0}, step;
  double goal[TL_MAX_BASE], change = 1.0;
  size_t bytes = (size_t)p->parameters * sizeof *value;

  base_at(p, best, goal);
  memcpy(value, best, bytes);
  do {
    for (step = 0; step < NEAREST_STEPS && change > NEAREST_TOLERANCE; step++) {
      tl_status status = nearest_step(p, goal, pinned, value, &change);
      if (status != TL_OK) return status;
    }
    if (!(change <= 1e-9)) {
      memcpy(value, best, bytes);
      return TL_OK;
    }
    change = 1.0;
  } while (pin_violated(p, pinned, value));
  return TL_OK;
}

/* ---- least squares over the free base parameters ------------------------ */

/* base parameters that a free parameter moves */
static int free_bases(const tl_problem *p, const double *value, int *index) {
  double jacobian[TL_MAX_BASE * TL_MAX_PARAMETERS];
  tl_model m = p->model;
  int b, i, n = 0;

  tl_parameters_set(&m, value);
  tl_base_jacobian(&m, jacobian);
  for (b = 0; b < p->bases; b++) {
    int moved = 0;
    for (i = 0; i < p->parameters; i++)
      moved |= is_free(p, NULL, i) && jacobian[tl_entry(p->parameters, b, i)] != 0.0;
    if (moved) index[n++] = b;
  }
  return n;
}

/* the factor over the free base parameters alone, the others moved to the right-hand side */
static tl_status free_factor(const tl_problem *p, const double *base, const int *index, int n,
                             tl_factor *out) {
  double block[(TL_MAX_BASE + 1) * (TL_MAX_BASE + 1)], held[TL_MAX_BASE];
  int i, k, rows = p->bases + 1;
  tl_status status = tl_factor_init(out, n);

  if (status != TL_OK) return status;
  memcpy(held, base, (size_t)p->bases * sizeof *held);
  for (k = 0; k < n; k++) held[index[k]] = 0.0;
  memset(block, 0, sizeof block);
  for (i = 0; i < rows; i++) {
    for (k = 0; k < n; k++)
      if (index[k] >= i) block[tl_entry(rows, k, i)] = tl_factor_row(&p->factor, i)[index[k]];
    block[tl_entry(rows, n, i)] = tl_factor_row(&p->factor, i)[p->bases];
    if (i < p->bases) block[tl_entry(rows, n, i)] -= r_row(&p->factor, i, held, 1);
  }
  tl_factor_add(out, block, (size_t)rows, (size_t)rows);
  return TL_OK;
}

/* largest over smallest singular value of the factor, columns at unit length;
 * directions that the data do not see count as 0: infinity */
static tl_status condition(const tl_factor *f, double *out) {
  double a[TL_MAX_BASE * TL_MAX_BASE] = {0}, s[TL_MAX_BASE], v[TL_MAX_BASE * TL_MAX_BASE];
  int i, j, n = f->columns;
  tl_status status;

  for (j = 0; j < n; j++) {
    double length = tl_factor_column_length(f, j);
    for (i = 0; i <= j && length > 0.0; i++) a[tl_entry(n, i, j)] = tl_factor_row(f, i)[j] / length;
  }
  status = tl_svd(a, n, n, s, v);
  *out = s[n - 1] > 0.0 ? s[0] / s[n - 1] : HUGE_VAL;
  return status;
}

/* cost at physical parameters, as tl_identify_cost at a point of the search */
static double cost_at(const tl_problem *p, const double *value) {
  double base[TL_MAX_BASE];

  base_at(p, value, base);
  return tl_factor_cost(&p->factor, base) / (double)p->factor.rows;
}

static tl_status certificate(const tl_problem *p, const double *value, tl_identify_result *out) {
  double b[TL_FACTOR_MAX];
  int index[TL_MAX_BASE], n = free_bases(p, value, index);
  tl_factor f;
  tl_status status = n > 0 ? free_factor(p, out->base, index, n, &f) : TL_ERR_SINGULAR;

  if (status == TL_OK) status = tl_factor_solve(&f, RANK_TOLERANCE, b, NULL);
  if (status != TL_OK) return status;
  out->least_squares_cost = tl_factor_cost(&f, b) / (double)p->factor.rows;
  return condition(&f, &out->condition_number);
}

/* ---- null space ---------------------------------------------------------- */

static void null_directions(const tl_problem *p, const view *w, tl_identify_result *out) {
  int i, j, k;

  for (i = 0; i < p->parameters; i++) out->identifiable[i] = 0;
  for (j = 0; j < w->columns; j++) out->identifiable[w->free_[j]] = 1;
  out->null_count = w->columns - w->kept;
  memset(out->null_direction, 0, sizeof out->null_direction);
  for (k = w->kept; k < w->columns; k++) {
    double *direction = out->null_direction[k - w->kept], largest = 0.0;
    for (j = 0; j < w->columns; j++) {
      double entry = w->v[tl_entry(w->columns, j, k)];
      if (fabs(entry) > fabs(largest)) largest = entry;
      direction[w->free_[j]] = entry;
      if (fabs(entry) > IN_NULL_SPACE) out->identifiable[w->free_[j]] = 0;
    }
    for (i = 0; i < p->parameters && largest < 0.0; i++) direction[i] = -direction[i];
  }
}

static void mark_bounds(const tl_problem *p, tl_identify_result *out) {
  int i;

  for (i = 0; i < p->parameters; i++) {
    double width = p->upper[i] - p->lower[i], near = 1e-9 * width;
    out->at_bound[i] =
        width > 0.0 && (out->value[i] <= p->lower[i] + near || out->value[i] >= p->upper[i] - near);
  }
}

tl_status tl_identify_conclude(const tl_problem *problem, const double *best, tl_identify_result *result) {
  view w;
  int i;
  tl_status status;

  if (!problem || !best || !result) return TL_ERR_ARGUMENT;
  memset(result, 0, sizeof *result);
  status = nearest_point(problem, best, result->value);
  if (status == TL_OK) status = view_init(problem, result->value, NULL, &w);
  if (status != TL_OK) return status;
  base_at(problem, result->value, result->base);
  null_directions(problem, &w, result);
  mark_bounds(problem, result);
  result->cost = cost_at(problem, best);
  for (i = 0; i < problem->parameters; i++) result->sigma[i] = (double)NAN;
  for (i = 0; i < problem->bases; i++) result->base_sigma[i] = (double)NAN;
  return certificate(problem, result->value, result);
}

/* ---- sigmas -------------------------------------------------------------- */

tl_status tl_sandwich_init(tl_sandwich *s, int bases, double block_s) {
  if (!s || bases < 1 || bases > TL_MAX_BASE || !(block_s > 0.0)) return TL_ERR_ARGUMENT;
  memset(s, 0, sizeof *s);
  s->bases = bases;
  s->block_s = block_s;
  return TL_OK;
}

void tl_sandwich_close(tl_sandwich *s) {
  int i, j;

  if (s->rows == 0) return;
  for (i = 0; i < s->bases; i++)
    for (j = 0; j < s->bases; j++) s->meat[tl_entry(s->bases, i, j)] += s->sum[i] * s->sum[j];
  memset(s->sum, 0, sizeof s->sum);
  s->blocks++;
  s->rows = 0;
}

void tl_sandwich_add(tl_sandwich *s, double t_s, const double *x, size_t stride, const int *index, int n,
                     double weight, double residual) {
  int k;

  if (s->rows > 0 && (t_s - s->begin_s >= s->block_s || t_s < s->begin_s)) tl_sandwich_close(s);
  if (s->rows++ == 0) s->begin_s = t_s;
  for (k = 0; k < n; k++) s->sum[index[k]] += weight * weight * residual * x[(size_t)k * stride];
}

/* out = K M K', K (rows x bases), M the meat with the correction for few blocks; diagonal's roots only */
static void propagate(const tl_sandwich *s, const double *k, int rows, int effective, double *sigma) {
  double correction = (double)s->blocks / (double)(s->blocks - (size_t)effective);
  int i, a, b;

  for (i = 0; i < rows; i++) {
    double sum = 0.0;
    for (a = 0; a < s->bases; a++)
      for (b = 0; b < s->bases; b++)
        sum += k[tl_entry(s->bases, i, a)] * s->meat[tl_entry(s->bases, a, b)] * k[tl_entry(s->bases, i, b)];
    sigma[i] = sqrt(correction * sum);
  }
}

/* K = S V diag(1 / s^2) V' S J' over the kept directions: change of the free
 * parameters per unit of the summed products x e */
static void parameter_gain(const tl_problem *p, const view *w, const double *jacobian, double *gain) {
  int i, j, b, k;

  memset(gain, 0, sizeof(double) * TL_MAX_PARAMETERS * TL_MAX_BASE);
  for (k = 0; k < w->kept; k++)
    for (b = 0; b < p->bases; b++) {
      double c = 0.0;
      for (j = 0; j < w->columns; j++)
        c += w->v[tl_entry(w->columns, j, k)] * p->scale[w->free_[j]] *
             jacobian[tl_entry(p->parameters, b, w->free_[j])];
      c /= w->singular[k] * w->singular[k];
      for (i = 0; i < w->columns; i++)
        gain[tl_entry(p->bases, w->free_[i], b)] +=
            p->scale[w->free_[i]] * w->v[tl_entry(w->columns, i, k)] * c;
    }
}

tl_status tl_identify_gain(const tl_problem *problem, const double *value, tl_gain *gain) {
  double jacobian[TL_MAX_BASE * TL_MAX_PARAMETERS];
  tl_model m = problem->model;
  view w;
  int i, a, b, n = problem->parameters;
  tl_status status = view_init(problem, value, NULL, &w);

  if (status != TL_OK) return status;
  memset(gain, 0, sizeof *gain);
  tl_parameters_set(&m, value);
  tl_base_jacobian(&m, jacobian);
  parameter_gain(problem, &w, jacobian, gain->parameter);
  gain->kept = w.kept;
  /* the base parameters move as the parameters do: J K */
  for (a = 0; a < problem->bases; a++)
    for (b = 0; b < problem->bases; b++)
      for (i = 0; i < n; i++)
        gain->base[tl_entry(problem->bases, a, b)] +=
            jacobian[tl_entry(n, a, i)] * gain->parameter[tl_entry(problem->bases, i, b)];
  return TL_OK;
}

tl_status tl_identify_sigma(const tl_problem *problem, const tl_sandwich *s, tl_identify_result *result) {
  tl_gain gain;
  int i;
  tl_status status;

  if (!problem || !s || !result || s->bases != problem->bases) return TL_ERR_ARGUMENT;
  if (s->blocks < (size_t)problem->bases + 2) return TL_ERR_TOO_SHORT;
  status = tl_identify_gain(problem, result->value, &gain);
  if (status != TL_OK) return status;
  propagate(s, gain.parameter, problem->parameters, gain.kept, result->sigma);
  propagate(s, gain.base, problem->bases, gain.kept, result->base_sigma);
  for (i = 0; i < problem->parameters; i++)
    if (!result->identifiable[i]) result->sigma[i] = (double)NAN;
  return TL_OK;
}
