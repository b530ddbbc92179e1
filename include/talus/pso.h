/* pso.h: a deterministic particle swarm.
 *
 * Each number a particle draws depends on (seed, restart, iteration, particle,
 * dimension) alone, and each generation reads only the bests of the one before;
 * so particles may be moved by any number of threads, in any order, and the
 * swarm is the same bit for bit.
 *
 * A particle at x with velocity v, best place of its own p and that of its
 * lead g goes on by v <- w v + c1 r1 (p - x) + c2 r2 (g - x), x <- x + v, no
 * further than the bounds' width; one that would leave is mirrored at the bound
 * and stopped.
 *
 *     tl_pso swarm;
 *     tl_pso_settings s = tl_pso_defaults();
 *     const double lower[2] = {-5.0, -5.0}, upper[2] = {5.0, 5.0};
 *     size_t memory_n = tl_pso_memory(&s, 2);
 *     double *memory = malloc(memory_n * sizeof *memory);
 *     if (!memory || tl_pso_init(&swarm, &s, 2, lower, upper, memory, memory_n) != TL_OK ||
 *         tl_pso_run(&swarm, cost, NULL) != TL_OK) return 1; // cost: (x - 1)^2 + (y + 2)^2
 *     printf("%.3f %.3f\n", swarm.best[0], swarm.best[1]); // prints 1.000 -2.000
 *     free(memory);
 */
#ifndef TALUS_PSO_H
#define TALUS_PSO_H

#include <stddef.h>
#include <stdint.h>

#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_PSO_MAX_DIMENSIONS 64

typedef enum tl_pso_form {
  TL_PSO_CONSTRICTION = 0, /* Clerc and Kennedy 2002 */
  TL_PSO_INERTIA = 1       /* Shi and Eberhart 1998, inertia falling linearly */
} tl_pso_form;

typedef enum tl_pso_topology { TL_PSO_GLOBAL = 0, TL_PSO_RING = 1 } tl_pso_topology;

/* common_draw: with r1, r2 drawn for each dimension (0, the textbook's swarm)
 * moves prefer the axes, and a narrow valley across them stops the swarm. With
 * one pair for all (1) they do not depend on how the axes lie, but stay in the
 * span of the swarm, which flattens. Mostly common draws with some of the other
 * kind keep both virtues. */
typedef struct tl_pso_settings {
  tl_pso_form form;
  tl_pso_topology topology;
  int particles;        /* 2 .. 1,000,000 */
  int iterations;       /* largest number of generations, >= 1 */
  int restarts;         /* independent swarms, the best one wins; >= 1 */
  double cognitive;     /* c1: pull to the particle's own best, 0..100 */
  double social;        /* c2: pull to the neighbourhood's best; constriction wants c1 + c2 > 4 */
  double inertia_begin; /* inertia form: weight w at the first generation, -1..1 */
  double inertia_end;   /* ... and at the last */
  double common_draw;   /* share of moves that take one r1, r2 for all dimensions, 0..1; see below */
  double tolerance;     /* stop when all particles' best costs are within this share of the best; 0: never */
  uint64_t seed;
} tl_pso_settings;

/* Constriction, global best, c1 = c2 = 2.05, 100 particles, at most 2,000 generations, one swarm,
 * nine moves in ten with common draws, tolerance 1e-14, seed 1: on the leg's ten parameters every
 * one of 200 seeds reaches the least-squares cost to 1e-14 in about 36,000 evaluations. */
tl_pso_settings tl_pso_defaults(void);

/* Cost of a point x (dimensions): finite or +infinity (NaN counts as that);
 * must be a pure function. A large constant in it costs digits of the answer:
 * near the optimum only what exceeds 1e-16 of the cost can be seen. */
typedef double (*tl_pso_cost)(const double *x, const void *context);

typedef struct tl_pso {
  tl_pso_settings settings;
  int dimensions;
  const double *lower, *upper; /* (dimensions), the caller's */
  int restart, iteration;      /* where it stands */
  uint64_t evaluations;
  double best_cost;            /* over all restarts */
  double *best;                /* (dimensions) */
  double *position, *velocity; /* (particles x dimensions) */
  double *cost;                /* (particles): of the positions, until tl_pso_close */
  double *own, *own_cost;      /* each particle's best */
  double *lead;                /* (particles): index of whom it follows, as double */
} tl_pso;

/* Doubles of memory a swarm needs. */
size_t tl_pso_memory(const tl_pso_settings *s, int dimensions);
/* lower < upper (or equal: the dimension stays). The bounds and the memory are
 * the caller's and must outlive the swarm. TL_ERR_ARGUMENT: null, or a count or
 * kind that is none; TL_ERR_RANGE: a weight or bound; TL_ERR_WORKSPACE. */
TL_CHECK tl_status tl_pso_init(tl_pso *swarm, const tl_pso_settings *s, int dimensions, const double *lower,
                               const double *upper, double *memory, size_t memory_n);
/* One generation by hand: move all particles, [first, last) at a time (threads
 * may share the work), then close it once. tl_pso_close returns 1 while there
 * is more to do, 0 at the end: then neither may be called again. */
void tl_pso_move(tl_pso *swarm, int first, int last, tl_pso_cost cost, const void *context);
int tl_pso_close(tl_pso *swarm);
/* All generations in the calling thread. TL_ERR_NOT_FINITE when no particle
 * ever had a finite cost. */
TL_CHECK tl_status tl_pso_run(tl_pso *swarm, tl_pso_cost cost, const void *context);

#ifdef __cplusplus
}
#endif
#endif
