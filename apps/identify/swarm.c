/* swarm.c: see swarm.h.
 *
 * Each thread moves its own range of particles; one of them closes the generation while the
 * others wait at the barrier. Particles do not see each other within a generation, so how
 * they are shared out does not matter.
 */
#include "swarm.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>

#include "common/progress.h"

struct shared {
  tl_pso *swarm;
  tl_pso_cost cost;
  const void *context;
  pthread_barrier_t barrier;
  pthread_mutex_t gate; /* held until all threads are there */
  int threads, started;
  int more; /* written by thread 0 between barriers */
  struct progress progress;
};

struct worker {
  struct shared *shared;
  int number;
  pthread_t thread;
};

/* after all particles have moved: is there more to do? */
static int close_generation(struct shared *s) {
  const tl_pso *swarm = s->swarm;
  const int more = tl_pso_close(s->swarm);
  const double share = (double)swarm->iteration / (double)swarm->settings.iterations;
  progress_update(&s->progress, ((double)swarm->restart + share) / (double)swarm->settings.restarts);
  return more;
}

static void *work(void *argument) {
  struct worker *w = argument;
  struct shared *s = w->shared;
  int particles = s->swarm->settings.particles;
  int first = particles * w->number / s->threads, last = particles * (w->number + 1) / s->threads;

  /* a barrier with a missing thread would wait for ever: go only when all have started */
  pthread_mutex_lock(&s->gate);
  if (s->started < s->threads) first = last = -1;
  pthread_mutex_unlock(&s->gate);
  if (first < 0) return NULL;
  do {
    tl_pso_move(s->swarm, first, last, s->cost, s->context);
    pthread_barrier_wait(&s->barrier);
    if (w->number == 0) s->more = close_generation(s);
    pthread_barrier_wait(&s->barrier);
  } while (s->more);
  return NULL;
}

static int start_and_join(struct shared *s, struct worker *workers, struct app_error *error) {
  pthread_mutex_lock(&s->gate);
  while (s->started < s->threads &&
         pthread_create(&workers[s->started].thread, NULL, work, &workers[s->started]) == 0)
    s->started++;
  pthread_mutex_unlock(&s->gate);
  for (int i = 0; i < s->started; i++) pthread_join(workers[i].thread, NULL);
  return s->started == s->threads ? 0 : app_fail(error, APP_FAILED, "cannot start %d threads", s->threads);
}

static int run_threads(struct shared *shared, struct app_error *error) {
  const int threads = shared->threads;
  struct worker *workers = calloc((size_t)threads, sizeof *workers);
  int result;

  if (!workers) return app_fail(error, APP_FAILED, "out of memory for %d threads", threads);
  for (int i = 0; i < threads; i++) workers[i] = (struct worker){.shared = shared, .number = i};
  pthread_barrier_init(&shared->barrier, NULL, (unsigned)threads);
  pthread_mutex_init(&shared->gate, NULL);
  result = start_and_join(shared, workers, error);
  pthread_mutex_destroy(&shared->gate);
  pthread_barrier_destroy(&shared->barrier);
  free(workers);
  return result;
}

static int run_alone(struct shared *s) {
  do {
    tl_pso_move(s->swarm, 0, s->swarm->settings.particles, s->cost, s->context);
  } while (close_generation(s));
  return 0;
}

int swarm_run(tl_pso *swarm, tl_pso_cost cost, const void *context, int threads, struct app_error *error) {
  struct shared shared = {.swarm = swarm, .cost = cost, .context = context, .threads = threads};
  int result;

  progress_begin(&shared.progress, "searching", NULL);
  result = threads <= 1 ? run_alone(&shared) : run_threads(&shared, error);
  progress_end(&shared.progress);
  if (result == 0 && !(swarm->best_cost < HUGE_VAL))
    result = app_fail(error, APP_FAILED, "the swarm: no particle ever had a finite cost");
  return result;
}
