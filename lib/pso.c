/* pso.c: a deterministic particle swarm.
 *
 * A generation has two halves. Moving writes only what belongs to the particle
 * moved (position, velocity, cost) and reads the bests, which stand still
 * meanwhile; closing brings the bests up to date, in index order. So it does
 * not matter who moves which particle when.
 */
#include "talus/pso.h"

#include <float.h>
#include <math.h>

#include "math_inline.h"
#include "random_inline.h"

#define PARTICLES_MAX 1000000
/* Keeps the swarm's numbers apart from those of tl_random_* under one seed. */
#define SWARM_KEY 0x7A3C19E5u
#define INFINITE (tl_of_bits(0x7ff0000000000000u))
#define NOT_A_NUMBER (tl_of_bits(0x7ff8000000000000u))

tl_pso_settings tl_pso_defaults(void) {
  tl_pso_settings s = {
      .form = TL_PSO_CONSTRICTION,
      .topology = TL_PSO_GLOBAL,
      .particles = 100,
      .iterations = 2000,
      .restarts = 1,
      .cognitive = 2.05,
      .social = 2.05,
      .inertia_begin = 0.9,
      .inertia_end = 0.4,
      .common_draw = 0.9,
      .tolerance = 1e-14,
      .seed = 1,
  };
  return s;
}

size_t tl_pso_memory(const tl_pso_settings *s, int dimensions) {
  size_t n = (size_t)s->particles, d = (size_t)dimensions;
  return n * (3 * d + 3) + d;
}

/* ---- settings and memory ------------------------------------------------- */

static int is_between(double x, double low, double high) {
  return x >= low && x <= high; /* false for NaN */
}

static tl_status check_settings(const tl_pso_settings *s) {
  if ((s->form != TL_PSO_CONSTRICTION && s->form != TL_PSO_INERTIA) ||
      (s->topology != TL_PSO_GLOBAL && s->topology != TL_PSO_RING) || s->particles < 2 ||
      s->particles > PARTICLES_MAX || s->iterations < 1 || s->restarts < 1) {
    return TL_ERR_ARGUMENT;
  }
  int weights = is_between(s->cognitive, 0.0, 100.0) && is_between(s->social, 0.0, 100.0) &&
                is_between(s->inertia_begin, -1.0, 1.0) && is_between(s->inertia_end, -1.0, 1.0) &&
                is_between(s->common_draw, 0.0, 1.0) && is_between(s->tolerance, 0.0, DBL_MAX);
  /* the constriction factor is defined beyond 4 only */
  int constricted = s->form != TL_PSO_CONSTRICTION || s->cognitive + s->social > 4.0;
  return weights && constricted ? TL_OK : TL_ERR_RANGE;
}

static tl_status check_bounds(int dimensions, const double *lower, const double *upper) {
  for (int d = 0; d < dimensions; d++) {
    if (!is_between(lower[d], -DBL_MAX, DBL_MAX) || !is_between(upper[d], lower[d], DBL_MAX) ||
        !(upper[d] - lower[d] <= DBL_MAX)) {
      return TL_ERR_RANGE;
    }
  }
  return TL_OK;
}

static double *take(double **memory, size_t n) {
  double *part = *memory;
  *memory += n;
  return part;
}

static void lay_out(tl_pso *swarm, double *memory) {
  size_t n = (size_t)swarm->settings.particles, d = (size_t)swarm->dimensions;
  swarm->best = take(&memory, d);
  swarm->position = take(&memory, n * d);
  swarm->velocity = take(&memory, n * d);
  swarm->own = take(&memory, n * d);
  swarm->cost = take(&memory, n);
  swarm->own_cost = take(&memory, n);
  swarm->lead = take(&memory, n);
}

tl_status tl_pso_init(tl_pso *swarm, const tl_pso_settings *s, int dimensions, const double *lower,
                      const double *upper, double *memory, size_t memory_n) {
  if (!swarm || !s || !lower || !upper || !memory || dimensions < 1 || dimensions > TL_PSO_MAX_DIMENSIONS) {
    return TL_ERR_ARGUMENT;
  }
  tl_status status = check_settings(s);
  if (status == TL_OK) {
    status = check_bounds(dimensions, lower, upper);
  }
  if (status == TL_OK && memory_n < tl_pso_memory(s, dimensions)) {
    status = TL_ERR_WORKSPACE;
  }
  if (status != TL_OK) {
    return status;
  }
  tl_pso made = {
      .settings = *s, .dimensions = dimensions, .lower = lower, .upper = upper, .best_cost = INFINITE};
  lay_out(&made, memory);
  for (int d = 0; d < dimensions; d++) {
    made.best[d] = NOT_A_NUMBER;
  }
  *swarm = made;
  return TL_OK;
}

/* ---- moving -------------------------------------------------------------- */

/* One block of four draws in (0, 1) with 32 bits each: enough for a direction,
 * and half as dear as 53. */
static void draw_block(const tl_pso *swarm, int particle, uint32_t block, double out[4]) {
  uint64_t seed = swarm->settings.seed;
  uint32_t counter[4] = {block, (uint32_t)particle, (uint32_t)swarm->iteration, (uint32_t)swarm->restart};
  uint32_t key[2] = {(uint32_t)seed, (uint32_t)(seed >> 32) ^ SWARM_KEY};
  uint32_t words[4];
  tl_philox_inline(counter, key, words);
  for (int i = 0; i < 4; i++) {
    out[i] = ((double)words[i] + 0.5) * 0x1p-32;
  }
}

/* two draws for each dimension: block 1 serves dimensions 0 and 1, and so on */
static void draw_each(const tl_pso *swarm, int particle, double *r1, double *r2) {
  for (int d = 0; d < swarm->dimensions; d += 2) {
    double r[4];
    draw_block(swarm, particle, 1 + (uint32_t)d / 2, r);
    r1[d] = r[0];
    r2[d] = r[1];
    r1[d + 1] = r[2];
    r2[d + 1] = r[3];
  }
}

/* Draws of a move: in a share `common_draw` of the moves one pair for all
 * dimensions, otherwise a pair for each. */
static void draw_move(const tl_pso *swarm, int particle, double *r1, double *r2) {
  double r[4];
  draw_block(swarm, particle, 0, r);
  if (r[2] >= swarm->settings.common_draw) {
    draw_each(swarm, particle, r1, r2);
    return;
  }
  for (int d = 0; d < swarm->dimensions; d++) {
    r1[d] = r[0];
    r2[d] = r[1];
  }
}

/* generation 0: uniform in the bounds, velocity towards another such point */
static void place(tl_pso *swarm, int particle, double *x, double *v) {
  double r1[TL_PSO_MAX_DIMENSIONS + 1], r2[TL_PSO_MAX_DIMENSIONS + 1];
  draw_each(swarm, particle, r1, r2);
  for (int d = 0; d < swarm->dimensions; d++) {
    double width = swarm->upper[d] - swarm->lower[d];
    x[d] = swarm->lower[d] + r1[d] * width;
    v[d] = (r2[d] - r1[d]) * width;
  }
}

typedef struct weights {
  double inertia, own, lead;
} weights;

/* Constriction (Clerc and Kennedy 2002): chi = 2 / (phi - 2 + sqrt(phi^2 - 4 phi)),
 * phi = c1 + c2 > 4, multiplies everything. */
static weights weights_now(const tl_pso *swarm) {
  const tl_pso_settings *s = &swarm->settings;
  if (s->form == TL_PSO_CONSTRICTION) {
    double phi = s->cognitive + s->social;
    double chi = 2.0 / (phi - 2.0 + sqrt(phi * phi - 4.0 * phi));
    return (weights){chi, chi * s->cognitive, chi * s->social};
  }
  double part = (double)swarm->iteration / (double)s->iterations;
  return (weights){s->inertia_begin + part * (s->inertia_end - s->inertia_begin), s->cognitive, s->social};
}

static double clamp(double x, double low, double high) {
  return x < low ? low : x > high ? high : x;
}

/* A particle that would leave is mirrored into the bounds and stopped there.
 * (Left on the bound with no velocity, it would hold the swarm to that face.) */
static void step_within(double *x, double *v, double low, double high) {
  double width = high - low, free = *x + *v;
  /* nearly always: nothing is in the way */
  if (free >= low && free <= high && fabs(*v) <= width) {
    *x = free;
    return;
  }
  double speed = clamp(*v, -width, width);
  double to = *x + speed;
  double mirrored = to < low ? low + (low - to) : to > high ? high - (to - high) : to;
  *v = mirrored == to ? speed : 0.0;
  *x = clamp(mirrored, low, high);
}

/* what draws a particle: its own best, its lead's, and how hard in each dimension */
typedef struct pull {
  const double *own, *lead;
  double r1[TL_PSO_MAX_DIMENSIONS + 1], r2[TL_PSO_MAX_DIMENSIONS + 1];
} pull;

static void accelerate(const weights *w, const pull *p, size_t n, const double *x, double *restrict v) {
  double inertia = w->inertia, to_own = w->own, to_lead = w->lead;
  for (size_t d = 0; d < n; d++) {
    v[d] = inertia * v[d] + to_own * p->r1[d] * (p->own[d] - x[d]) + to_lead * p->r2[d] * (p->lead[d] - x[d]);
  }
}

static void fly(tl_pso *swarm, int particle, const weights *w, double *x, double *v) {
  size_t n = (size_t)swarm->dimensions;
  pull p;
  p.own = swarm->own + (size_t)particle * n;
  p.lead = swarm->own + (size_t)swarm->lead[particle] * n;
  draw_move(swarm, particle, p.r1, p.r2);
  accelerate(w, &p, n, x, v);
  for (size_t d = 0; d < n; d++) {
    step_within(&x[d], &v[d], swarm->lower[d], swarm->upper[d]);
  }
}

void tl_pso_move(tl_pso *swarm, int first, int last, tl_pso_cost cost, const void *context) {
  weights w = weights_now(swarm);
  size_t n = (size_t)swarm->dimensions;
  for (int i = first; i < last; i++) {
    double *x = swarm->position + (size_t)i * n;
    double *v = swarm->velocity + (size_t)i * n;
    if (swarm->iteration == 0) {
      place(swarm, i, x, v);
    } else {
      fly(swarm, i, &w, x, v);
    }
    double value = cost(x, context);
    swarm->cost[i] = value == value ? value : INFINITE;
  }
}

/* ---- closing ------------------------------------------------------------- */

static void copy(double *to, const double *from, int n) {
  for (int i = 0; i < n; i++) {
    to[i] = from[i];
  }
}

static void remember(tl_pso *swarm) {
  int n = swarm->dimensions;
  for (int i = 0; i < swarm->settings.particles; i++) {
    if (swarm->iteration == 0 || swarm->cost[i] < swarm->own_cost[i]) {
      size_t start = (size_t)i * (size_t)n;
      copy(swarm->own + start, swarm->position + start, n);
      swarm->own_cost[i] = swarm->cost[i];
    }
  }
}

static int better(const tl_pso *swarm, int i, int j) {
  return swarm->own_cost[j] < swarm->own_cost[i] ? j : i;
}

static int best_of_all(const tl_pso *swarm) {
  int best = 0;
  for (int i = 1; i < swarm->settings.particles; i++) {
    best = better(swarm, best, i);
  }
  return best;
}

/* whom each particle follows: the best of all, or of itself and its two neighbours on the ring */
static void choose_leads(tl_pso *swarm, int best) {
  int n = swarm->settings.particles;
  for (int i = 0; i < n; i++) {
    int lead = best;
    if (swarm->settings.topology == TL_PSO_RING) {
      lead = better(swarm, better(swarm, i, (i + n - 1) % n), (i + 1) % n);
    }
    swarm->lead[i] = (double)lead;
  }
}

/* all own bests cost the same, within tolerance */
static int has_converged(const tl_pso *swarm, int best) {
  double least = swarm->own_cost[best];
  double most = least;
  for (int i = 0; i < swarm->settings.particles; i++) {
    most = swarm->own_cost[i] > most ? swarm->own_cost[i] : most;
  }
  return swarm->settings.tolerance > 0.0 && most - least <= swarm->settings.tolerance * fabs(least);
}

int tl_pso_close(tl_pso *swarm) {
  remember(swarm);
  swarm->evaluations += (uint64_t)swarm->settings.particles;
  int best = best_of_all(swarm);
  if (swarm->own_cost[best] < swarm->best_cost) {
    swarm->best_cost = swarm->own_cost[best];
    copy(swarm->best, swarm->own + (size_t)best * (size_t)swarm->dimensions, swarm->dimensions);
  }
  choose_leads(swarm, best);
  swarm->iteration++;
  if (swarm->iteration >= swarm->settings.iterations || has_converged(swarm, best)) {
    swarm->restart++;
    swarm->iteration = 0;
  }
  return swarm->restart < swarm->settings.restarts;
}

tl_status tl_pso_run(tl_pso *swarm, tl_pso_cost cost, const void *context) {
  if (!swarm || !cost) {
    return TL_ERR_ARGUMENT;
  }
  do {
    tl_pso_move(swarm, 0, swarm->settings.particles, cost, context);
  } while (tl_pso_close(swarm));
  return is_between(swarm->best_cost, -DBL_MAX, DBL_MAX) ? TL_OK : TL_ERR_NOT_FINITE;
}
