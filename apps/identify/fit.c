/* fit.c: see fit.h. */
#include "fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fold.h"
#include "reread.h"
#include "swarm.h"

#define BLOCK_S 0.5 /* residuals further apart than this count as independent */
#define HUBER_PASSES 12
#define WIDEN_MOST 4

/* ---- the search ------------------------------------------------------------- */

static int set_problem(struct fit *fit, const tl_model *model, const struct fit_settings *settings,
                       const tl_factor *factor, const char *path, struct app_error *error) {
  tl_status status = tl_problem_init(&fit->problem, model, &settings->identify, factor);

  if (status == TL_OK) return 0;
  if (status == TL_ERR_TOO_SHORT)
    return app_fail(error, APP_BAD_INPUT,
                    "%s: too few samples in motion: after standstill and the ends of segments are left out, "
                    "no joint has more rows than parameters",
                    path);
  return app_fail(error, APP_BAD_INPUT, "%s",
                  status == TL_ERR_RANGE ? "bounds: a lower bound lies above its upper one, or outside the "
                                           "parameter's physical range"
                                         : tl_status_text(status));
}

/* linear least squares for Huber's weights; iterated reweighting (Holland and Welsch 1977) */
static int reweight(struct fit *fit, struct folding *f, const tl_model *model,
                    const struct fit_settings *settings, struct stream *const *stream, int streams,
                    struct app_error *error) {
  f->robust = 1;
  for (int pass = 0; pass < HUBER_PASSES; pass++) {
    tl_status status = tl_factor_solve(&fit->problem.factor, 1e-10, f->base, NULL);
    if (status != TL_OK) return app_fail(error, APP_FAILED, "%s", tl_status_text(status));
    memcpy(f->scale, fit->problem.noise, sizeof f->scale);
    if (fold_all(f, model, stream, streams, error) != 0) return -1;
    if (set_problem(fit, model, settings, f->factor, stream_path(stream[0]), error) != 0) return -1;
  }
  return 0;
}

static int one_swarm(struct fit *fit, int threads, double *best, struct app_error *error) {
  const tl_problem *p = &fit->problem;
  size_t n = tl_identify_memory(p);
  double *memory = malloc(n * sizeof *memory);
  tl_pso swarm;
  tl_status status;
  int result;

  if (!memory)
    return app_fail(error, APP_FAILED, "out of memory for %d particles", p->settings.swarm.particles);
  status =
      tl_pso_init(&swarm, &p->settings.swarm, p->parameters, p->search_lower, p->search_upper, memory, n);
  result = status == TL_OK ? swarm_run(&swarm, tl_identify_cost, p, threads, error)
                           : app_fail(error, APP_BAD_INPUT, "swarm settings: %s", tl_status_text(status));
  if (result == 0) {
    tl_problem_parameters(p, swarm.best, best);
    fit->evaluations += swarm.evaluations;
  }
  free(memory);
  return result;
}

static int search(struct fit *fit, int threads, struct app_error *error) {
  double best[TL_MAX_PARAMETERS];
  tl_status status;

  do {
    if (one_swarm(fit, threads, best, error) != 0) return -1;
  } while (fit->widened < WIDEN_MOST && tl_problem_widen(&fit->problem, best) && ++fit->widened);
  status = tl_identify_conclude(&fit->problem, best, &fit->result);
  return status == TL_OK ? 0 : app_fail(error, APP_FAILED, "%s", tl_status_text(status));
}

/* ---- second pass: errors and standard deviations ------------------------------ */

struct judging {
  struct fit *fit;
  tl_sandwich sandwich;
  double nominal[TL_MAX_BASE];
  int recording;
  fit_trace trace;
  void *context;
};

static void judge_row(struct judging *g, const tl_rows *rows, int joint, size_t k, double t_s) {
  double measured = tl_rows_measured(rows, k);
  double nominal = tl_rows_residual(rows, g->nominal, k),
         rest = tl_rows_residual(rows, g->fit->result.base, k);
  struct fit_error *e = &g->fit->error[joint];
  struct fit_instant now = {g->recording,       joint,           t_s,          measured,
                            measured - nominal, measured - rest, rows->kind[k]};

  scored_add(&e->nominal, rows->kind[k], measured, nominal);
  scored_add(&e->identified, rows->kind[k], measured, rest);
  if (rows->kind[k] == TL_ROW_SCORED)
    tl_sandwich_add(&g->sandwich, t_s, rows->x + k, rows->stride, rows->index, rows->columns,
                    g->fit->problem.weight[joint], rest);
  if (g->trace) g->trace(&now, g->context);
}

static int judge_part(const struct stream_part *part, void *context, struct app_error *error) {
  struct judging *g = context;
  const tl_rows *rows = part->space->rows;

  (void)error;
  for (size_t k = 0; k < rows[0].n; k++)
    for (int j = 0; j < g->fit->problem.joints; j++)
      judge_row(g, &rows[j], j, k, rows[0].begin_s + (double)k * part->regression->step_s);
  return 0;
}

static int judge(struct fit *fit, const tl_model *model, struct stream *const *stream, int streams,
                 fit_trace trace, void *context, struct app_error *error) {
  struct judging g = {.fit = fit, .trace = trace, .context = context};
  tl_status status = tl_sandwich_init(&g.sandwich, fit->problem.bases, BLOCK_S);

  tl_base_values(model, g.nominal);
  for (g.recording = 0; status == TL_OK && g.recording < streams; g.recording++) {
    stream_set_task(stream[g.recording], "judging");
    if (stream_rows(stream[g.recording], judge_part, &g, error) != 0) return -1;
    tl_sandwich_close(&g.sandwich);
  }
  if (status == TL_OK) status = tl_identify_sigma(&fit->problem, &g.sandwich, &fit->result);
  fit->few_blocks = status == TL_ERR_TOO_SHORT;
  return status == TL_OK || fit->few_blocks ? 0 : app_fail(error, APP_FAILED, "%s", tl_status_text(status));
}

/* what residuals do not show; without standard deviations there is nothing to add to */
static int find_systematic(struct fit *fit, struct folding *f, const struct inputs *in,
                           struct app_error *error) {
  tl_status status = TL_OK;

  if (fit->few_blocks) return 0;
  if (reread_all(fit->readings, f, &fit->problem, in, error) != 0) return -1;
  status = tl_identify_readings(&fit->problem, fit->readings, &fit->result);
  return status == TL_OK ? 0 : app_fail(error, APP_FAILED, "%s", tl_status_text(status));
}

static int fit_folded(struct fit *fit, struct folding *f, const tl_model *model,
                      const struct fit_settings *settings, const struct inputs *in, fit_trace trace,
                      void *context, struct app_error *error) {
  if (fold_all(f, model, in->stream, in->n, error) != 0) return -1;
  if (set_problem(fit, model, settings, f->factor, stream_path(in->stream[0]), error) != 0) return -1;
  if (settings->huber && reweight(fit, f, model, settings, in->stream, in->n, error) != 0) return -1;
  if (search(fit, settings->threads, error) != 0) return -1;
  if (judge(fit, model, in->stream, in->n, trace, context, error) != 0) return -1;
  return find_systematic(fit, f, in, error);
}

int fit_run(struct fit *fit, const tl_model *model, const struct fit_settings *settings,
            const struct inputs *in, fit_trace trace, void *context, struct app_error *error) {
  struct folding f = {.joints = tl_joint_count(model), .task = "fitting"};
  int result;

  memset(fit, 0, sizeof *fit);
  f.factor = calloc((size_t)f.joints, sizeof *f.factor);
  fit->readings = malloc(sizeof *fit->readings);
  result = f.factor && fit->readings ? fit_folded(fit, &f, model, settings, in, trace, context, error)
                                     : app_fail(error, APP_FAILED, "out of memory");
  fold_free(&f);
  free(fit->readings);
  fit->readings = NULL;
  return result;
}
