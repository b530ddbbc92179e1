/* identify.c: the swarm's problem; see talus/identify.h. */
#include "talus/identify.h"

#include <math.h>
#include <string.h>

#include "math_inline.h"
#include "talus/math.h"

#define PRIOR_FACTOR 10.0 /* default upper bound, in priors */
#define COLUMN_FACTOR 3.0 /* where the prior is 0: in torques that the column alone would explain */
#define LEAST_SHARE 1e-6  /* of the upper bound: where a parameter that must be positive ends */
#define NEAR_BOUND 1e-3   /* of the bounds' width */

tl_identify_settings tl_identify_defaults(void) {
  tl_identify_settings s;

  memset(&s, 0, sizeof s);
  s.swarm = tl_pso_defaults();
  s.weighting = TL_WEIGHT_NOISE;
  s.null_tolerance = 1e-8;
  return s;
}

/* RMS residual of one joint's own least squares, from its factor's last entry */
static double own_residual(const tl_factor *f) {
  double b[TL_FACTOR_MAX];

  if (f->rows == 0 || tl_factor_solve(f, 1e-10, b, NULL) != TL_OK) return 0.0;
  return sqrt(tl_factor_cost(f, b) / (double)f->rows);
}

/* does a joint have enough rows to tell its own noise? One that hardly moves has not */
static int has_rows(const tl_factor *f) {
  return f->rows > (size_t)f->columns;
}

tl_status tl_problem_merge(const tl_problem *problem, const tl_factor *factor, tl_factor *merged) {
  int j, index[TL_MAX_ROW];
  tl_status status;

  if (!problem || !factor || !merged) return TL_ERR_ARGUMENT;
  status = tl_factor_init(merged, problem->bases);
  for (j = 0; j < problem->joints && status == TL_OK; j++) {
    if (!(problem->weight[j] > 0.0) || factor[j].rows == 0) continue;
    tl_row_index(&problem->model, j, index);
    tl_factor_merge(merged, &factor[j], index, problem->weight[j]);
  }
  return status;
}

/* all joints in one factor, each weighted so that noise counts the same everywhere;
 * the few rows of a joint that hardly moves weigh nothing */
static tl_status combine(tl_problem *p, const tl_factor *factor) {
  int j;
  double least = 0.0, most = 0.0;
  tl_status status = TL_OK;

  for (j = 0; j < p->joints && status == TL_OK; j++) {
    p->noise[j] = has_rows(&factor[j]) ? own_residual(&factor[j]) : 0.0;
    most = p->noise[j] > most ? p->noise[j] : most;
  }
  /* a joint without any residual (noise-free data) must not weigh infinitely */
  least = most > 0.0 ? 1e-6 * most : 1.0;
  for (j = 0; j < p->joints && status == TL_OK; j++) {
    double noise = p->noise[j] > least ? p->noise[j] : least;
    if (!has_rows(&factor[j])) continue;
    p->weight[j] = p->settings.weighting == TL_WEIGHT_NOISE ? 1.0 / noise : 1.0;
  }
  if (status == TL_OK) status = tl_problem_merge(p, factor, &p->factor);
  return status == TL_OK && p->factor.rows == 0 ? TL_ERR_TOO_SHORT : status;
}

/* the size at which parameter i alone would explain the whole torque, through its base parameters */
static double natural_size(const tl_problem *p, const double *jacobian, int i) {
  double torque = tl_factor_column_length(&p->factor, p->bases), size = 0.0;
  int b;

  for (b = 0; b < p->bases; b++) {
    double share = fabs(jacobian[tl_entry(p->parameters, b, i)]) * tl_factor_column_length(&p->factor, b);
    if (share > 0.0 && (size == 0.0 || torque / share < size)) size = torque / share;
  }
  return size > 0.0 ? size : 1.0;
}

/* search bounds: the user's, or from the prior's size, or from the data's */
static tl_status set_bounds(tl_problem *p) {
  double jacobian[TL_MAX_BASE * TL_MAX_PARAMETERS];
  int i, n;
  const tl_parameter *table = tl_parameters(&p->model, &n);

  tl_base_jacobian(&p->model, jacobian);
  for (i = 0; i < n; i++) {
    double size = COLUMN_FACTOR * natural_size(p, jacobian, i);
    if (p->settings.bounded[i]) {
      p->lower[i] = p->settings.lower[i];
      p->upper[i] = p->settings.upper[i];
    } else {
      if (p->prior[i] != 0.0) size = PRIOR_FACTOR * fabs(p->prior[i]);
      if (table[i].angle) size = TL_PI;
      p->upper[i] = size;
      p->lower[i] = table[i].lower > -size ? table[i].lower : -size;
      if (table[i].positive) p->lower[i] += LEAST_SHARE * size;
    }
    if (p->settings.fixed[i]) p->lower[i] = p->upper[i] = p->prior[i];
    if (!(p->lower[i] <= p->upper[i]) || p->lower[i] < table[i].lower) return TL_ERR_RANGE;
    p->scale[i] = p->prior[i] != 0.0 ? fabs(p->prior[i]) : 0.1 * (p->upper[i] - p->lower[i]);
    if (!(p->scale[i] > 0.0)) p->scale[i] = 1.0;
  }
  return TL_OK;
}

/* the swarm's own bounds; the two components of gravity where both are free and unbounded */
static void set_search(tl_problem *p) {
  int i, n;
  const tl_parameter *table = tl_parameters(&p->model, &n);

  p->gravity = -1;
  for (i = 0; i < n; i++) {
    p->search_lower[i] = p->lower[i];
    p->search_upper[i] = p->upper[i];
  }
  for (i = 1; i < n; i++) {
    const tl_identify_settings *s = &p->settings;
    if (!table[i].angle || s->bounded[i] || s->bounded[i - 1] || s->fixed[i] || s->fixed[i - 1]) continue;
    p->gravity = i - 1;
    p->search_upper[i] = p->search_upper[i - 1];
    p->search_lower[i] = p->search_lower[i - 1] = -p->search_upper[i];
  }
}

void tl_problem_parameters(const tl_problem *problem, const double *x, double *value) {
  int g = problem->gravity;

  memcpy(value, x, (size_t)problem->parameters * sizeof *value);
  if (g < 0) return;
  value[g] = sqrt(x[g] * x[g] + x[g + 1] * x[g + 1]);
  value[g + 1] = tl_atan2(x[g + 1], x[g]);
}

tl_status tl_problem_init(tl_problem *problem, const tl_model *prior, const tl_identify_settings *s,
                          const tl_factor *factor) {
  tl_status status;

  if (!problem || !prior || !s || !factor) return TL_ERR_ARGUMENT;
  memset(problem, 0, sizeof *problem);
  problem->model = *prior;
  problem->settings = *s;
  problem->joints = tl_joint_count(prior);
  problem->bases = tl_base_count(prior);
  tl_parameters(prior, &problem->parameters);
  tl_parameters_get(prior, problem->prior);
  status = combine(problem, factor);
  if (status == TL_OK) status = set_bounds(problem);
  if (status == TL_OK) set_search(problem);
  return status;
}

double tl_identify_cost(const double *x, const void *context) {
  const tl_problem *p = context;
  double base[TL_MAX_BASE], value[TL_MAX_PARAMETERS];

  tl_problem_parameters(p, x, value);
  tl_base_at(&p->model, value, base);
  /* the constant part, which no parameter changes, would hide the last digits */
  return tl_factor_excess(&p->factor, base) / (double)p->factor.rows;
}

size_t tl_identify_memory(const tl_problem *problem) {
  return tl_pso_memory(&problem->settings.swarm, problem->parameters);
}

tl_status tl_identify_swarm(const tl_problem *problem, double *memory, size_t memory_n, double *best,
                            uint64_t *evaluations) {
  tl_pso swarm;
  tl_status status = tl_pso_init(&swarm, &problem->settings.swarm, problem->parameters, problem->search_lower,
                                 problem->search_upper, memory, memory_n);

  if (status == TL_OK) status = tl_pso_run(&swarm, tl_identify_cost, problem);
  if (status != TL_OK) return status;
  tl_problem_parameters(problem, swarm.best, best);
  if (evaluations) *evaluations = swarm.evaluations;
  return TL_OK;
}

int tl_problem_widen(tl_problem *problem, const double *best) {
  int i, n, widened = 0;
  const tl_parameter *table = tl_parameters(&problem->model, &n);

  for (i = 0; i < n; i++) {
    double width = problem->upper[i] - problem->lower[i];
    int above = best[i] > problem->upper[i] - NEAR_BOUND * width;
    int below = best[i] < problem->lower[i] + NEAR_BOUND * width && problem->lower[i] < 0.0;

    if (problem->settings.bounded[i] || problem->settings.fixed[i] || table[i].angle || !(above || below))
      continue;
    problem->upper[i] *= above ? PRIOR_FACTOR : 1.0;
    problem->lower[i] *= below ? PRIOR_FACTOR : 1.0;
    widened = 1;
  }
  if (widened) set_search(problem);
  return widened;
}
