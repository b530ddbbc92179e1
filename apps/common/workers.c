/* workers.c: see workers.h. */
#include "workers.h"

#include <pthread.h>
#include <unistd.h>

struct thread {
  pthread_t id;
  void (*work)(void *worker);
  void *worker;
};

int workers_processors(void) {
  const long processors = sysconf(_SC_NPROCESSORS_ONLN);
  return processors < 1 ? 1 : processors > WORKERS_MOST ? WORKERS_MOST : (int)processors;
}

static void *run(void *argument) {
  const struct thread *thread = argument;
  thread->work(thread->worker);
  return NULL;
}

void workers_run(void (*work)(void *worker), void *const *worker, int n) {
  struct thread thread[WORKERS_MOST];
  int started = 1;
  for (; started < n; started++) {
    thread[started] = (struct thread){.work = work, .worker = worker[started]};
    if (pthread_create(&thread[started].id, NULL, run, &thread[started]) != 0) break;
  }
  work(worker[0]);
  for (int i = 1; i < started; i++) pthread_join(thread[i].id, NULL);
}
