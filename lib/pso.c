/* pso.c: see talus/pso.h. */
#include "talus/pso.h"

#include <math.h>
#include <string.h>

#include "random_inline.h"

tl_pso_settings tl_pso_defaults(void)
{
  tl_pso_settings s = {TL_PSO_CONSTRICTION, TL_PSO_GLOBAL, 100, 1000, 1, 2.05, 2.05, 0.9, 0.4, 0.0, 1};
  return s;
}

size_t tl_pso_memory(const tl_pso_settings *s, int dimensions)
{
  size_t p = (size_t)s->particles, d = (size_t)dimensions;

  return 3 * p * d + 3 * p + d;
}

static int settings_fit(const tl_pso_settings *s)
{
  return s->particles >= 2 && s->iterations >= 1 && s->restarts >= 1 && s->cognitive >= 0.0 && s->social >= 0.0 &&
         s->tolerance >= 0.0;
}

tl_status tl_pso_init(tl_pso *swarm, const tl_pso_settings *s, int dimensions, const double *lower,
                      const double *upper, double *memory, size_t memory_n)
{
  size_t p, d = (size_t)dimensions;
  int i;

  if (!swarm || !s || !lower || !upper || !memory) return TL_ERR_ARGUMENT;
  if (dimensions < 1 || dimensions > TL_PSO_MAX_DIMENSIONS || !settings_fit(s)) return TL_ERR_RANGE;
  for (i = 0; i < dimensions; i++)
    if (!(lower[i] <= upper[i])) return TL_ERR_RANGE;
  if (memory_n < tl_pso_memory(s, dimensions)) return TL_ERR_WORKSPACE;
  p = (size_t)s->particles;
  memset(swarm, 0, sizeof *swarm);
  swarm->settings = *s;
  swarm->dimensions = dimensions;
  swarm->lower = lower;
  swarm->upper = upper;
  swarm->best_cost = HUGE_VAL;
  swarm->position = memory;
  swarm->velocity = memory + p * d;
  swarm->own = memory + 2 * p * d;
  swarm->own_cost = memory + 3 * p * d;
  swarm->cost = swarm->own_cost + p;
  swarm->lead = swarm->cost + p;
  swarm->best = swarm->lead + p;
  memcpy(swarm->best, lower, d * sizeof *lower);
  return TL_OK;
}

/* two uniform numbers for one dimension of one particle at one generation */
static void draw(const tl_pso *s, int particle, int dimension, double out[2])
{
  uint64_t counter = ((uint64_t)s->iteration << 32) | ((uint64_t)particle << 8) | (uint64_t)dimension;

  tl_random_uniform2_inline(s->settings.seed, (uint64_t)s->restart, counter, out);
}

/* anywhere within the bounds, at rest */
static void scatter(tl_pso *s, int particle)
{
  size_t at = (size_t)particle * (size_t)s->dimensions;
  double r[2];
  int d;

  for (d = 0; d < s->dimensions; d++) {
    draw(s, particle, d, r);
    s->position[at + (size_t)d] = s->lower[d] + r[0] * (s->upper[d] - s->lower[d]);
    s->velocity[at + (size_t)d] = 0.0;
  }
}

/* weights of the old velocity and of both pulls together */
static void weights(const tl_pso *s, double *inertia, double *pull)
{
  const tl_pso_settings *p = &s->settings;
  double phi = p->cognitive + p->social, way;

  *inertia = *pull = 1.0;
  if (p->form == TL_PSO_INERTIA) {
    way = p->iterations > 1 ? (double)s->iteration / (double)(p->iterations - 1) : 0.0;
    *inertia = p->inertia_begin + way * (p->inertia_end - p->inertia_begin);
  } else if (phi > 4.0) {
    *inertia = *pull = 2.0 / fabs(2.0 - phi - sqrt(phi * phi - 4.0 * phi)); /* Clerc and Kennedy, (8) */
  }
}

/* one step; who would leave the bounds ends half way to them, at rest */
static void step(tl_pso *s, int particle, double inertia, double pull)
{
  size_t at = (size_t)particle * (size_t)s->dimensions, lead = (size_t)s->lead[particle] * (size_t)s->dimensions;
  double r[2];
  int d;

  for (d = 0; d < s->dimensions; d++) {
    double *x = &s->position[at + (size_t)d], *v = &s->velocity[at + (size_t)d], next;
    double low = s->lower[d], high = s->upper[d];

    draw(s, particle, d, r);
    *v = inertia * *v + pull * (s->settings.cognitive * r[0] * (s->own[at + (size_t)d] - *x) +
                                s->settings.social * r[1] * (s->own[lead + (size_t)d] - *x));
    next = *x + *v;
    if (next < low || next > high) {
      next = 0.5 * (*x + (next < low ? low : high));
      *v = 0.0;
    }
    *x = next;
  }
}

void tl_pso_move(tl_pso *swarm, int first, int last, tl_pso_cost cost, const void *context)
{
  double inertia, pull;
  int i;

  weights(swarm, &inertia, &pull);
  for (i = first; i < last; i++) {
    if (swarm->iteration == 0)
      scatter(swarm, i);
    else
      step(swarm, i, inertia, pull);
    swarm->cost[i] = cost(swarm->position + (size_t)i * (size_t)swarm->dimensions, context);
  }
}

/* bests of every particle, in the order of the particles */
static void remember(tl_pso *s)
{
  size_t d = (size_t)s->dimensions, bytes = d * sizeof(double), i;

  for (i = 0; i < (size_t)s->settings.particles; i++) {
    if (s->iteration == 0 || s->cost[i] < s->own_cost[i]) {
      s->own_cost[i] = s->cost[i] < HUGE_VAL ? s->cost[i] : HUGE_VAL;
      memcpy(s->own + i * d, s->position + i * d, bytes);
    }
    if (s->own_cost[i] < s->best_cost) {
      s->best_cost = s->own_cost[i];
      memcpy(s->best, s->own + i * d, bytes);
    }
  }
}

/* whom each particle follows: the best of all, or of itself and its two neighbours */
static void choose_leads(tl_pso *s)
{
  int n = s->settings.particles, best = 0, i;

  for (i = 1; i < n; i++)
    if (s->own_cost[i] < s->own_cost[best]) best = i;
  for (i = 0; i < n; i++) {
    int left = (i + n - 1) % n, right = (i + 1) % n, lead = i;
    if (s->own_cost[left] < s->own_cost[lead]) lead = left;
    if (s->own_cost[right] < s->own_cost[lead]) lead = right;
    s->lead[i] = s->settings.topology == TL_PSO_RING ? lead : best;
  }
}

/* largest extent of the particles' bests, in units of the bounds' width */
static double spread(const tl_pso *s)
{
  double most = 0.0;
  int d, i;

  for (d = 0; d < s->dimensions; d++) {
    double low = s->own[d], high = s->own[d], width = s->upper[d] - s->lower[d];
    for (i = 1; i < s->settings.particles; i++) {
      double x = s->own[i * s->dimensions + d];
      low = x < low ? x : low;
      high = x > high ? x : high;
    }
    if (width > 0.0 && (high - low) / width > most) most = (high - low) / width;
  }
  return most;
}

int tl_pso_close(tl_pso *swarm)
{
  const tl_pso_settings *s = &swarm->settings;

  remember(swarm);
  choose_leads(swarm);
  swarm->evaluations += (uint64_t)s->particles;
  swarm->iteration++;
  if (swarm->iteration < s->iterations && !(s->tolerance > 0.0 && spread(swarm) < s->tolerance)) return 1;
  swarm->iteration = 0;
  swarm->restart++;
  return swarm->restart < s->restarts;
}

tl_status tl_pso_run(tl_pso *swarm, tl_pso_cost cost, const void *context)
{
  if (!swarm || !cost) return TL_ERR_ARGUMENT;
  do tl_pso_move(swarm, 0, swarm->settings.particles, cost, context);
  while (tl_pso_close(swarm));
  return swarm->best_cost < HUGE_VAL ? TL_OK : TL_ERR_NOT_FINITE;
}
