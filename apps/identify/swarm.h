/* swarm.h: a particle swarm moved by several threads; the same bits for any number of them. */
#ifndef SWARM_H
#define SWARM_H

#include "common/error.h"
#include "talus/pso.h"

/* Runs the swarm to its end with `threads` threads (>= 1). */
int swarm_run(tl_pso *swarm, tl_pso_cost cost, const void *context, int threads, struct app_error *error);

#endif
