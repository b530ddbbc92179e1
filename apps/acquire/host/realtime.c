/* realtime.c: locked memory, SCHED_FIFO, counters. */
#define _GNU_SOURCE

#include "realtime.h"

#include <errno.h>
#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include "allocations.h"

enum { STACK_TOUCHED = 128 << 10, PAGE = 4096, LATER_NEEDS = 40 << 20 };

/* Everything from now on is locked as well: is there leave for it? Else a later thread could not be started. */
static int lock_all(void) {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) return errno;
  void *more = mmap(NULL, LATER_NEEDS, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (more != MAP_FAILED) return munmap(more, LATER_NEEDS) == 0 ? 0 : errno;
  const int reason = errno;
  munlockall();
  return reason;
}

static int refuse_deep_sleep(struct realtime *rt) {
  const int32_t zero_us = 0;
  rt->latency_fd = open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
  if (rt->latency_fd < 0) return errno;
  return write(rt->latency_fd, &zero_us, sizeof zero_us) == (ssize_t)sizeof zero_us ? 0 : errno;
}

static int set_class(int policy, int priority) {
  const struct sched_param parameter = {.sched_priority = priority};
  return pthread_setschedparam(pthread_self(), policy, &parameter);
}

void realtime_prepare(struct realtime *rt, int wanted) {
  memset(rt, 0, sizeof *rt);
  rt->wanted = wanted;
  rt->latency_fd = -1;
#if defined(__GLIBC__)
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
#endif
  if (!wanted) return;
  rt->lock_refused = lock_all();
  rt->fifo_refused = set_class(SCHED_FIFO, REALTIME_WRITER);
  if (!rt->fifo_refused) set_class(SCHED_OTHER, 0);
  rt->latency_refused = refuse_deep_sleep(rt);
}

void realtime_release(struct realtime *rt) {
  if (rt->latency_fd >= 0) close(rt->latency_fd);
  rt->latency_fd = -1;
}

/* one write in every page of the stack that the loop may come to use */
static void touch_stack(void) {
  volatile char page[STACK_TOUCHED];
  for (int i = 0; i < STACK_TOUCHED; i += PAGE) page[i] = 0;
  (void)page[0];
}

void realtime_enter(const struct realtime *rt, int priority) {
  if (rt->wanted && !rt->fifo_refused) set_class(SCHED_FIFO, priority);
  touch_stack();
}

struct loop_count loop_count_now(void) {
  struct rusage usage = {.ru_minflt = 0};
  getrusage(RUSAGE_SELF, &usage);
  return (struct loop_count){usage.ru_minflt, usage.ru_majflt, allocations()};
}

struct loop_count loop_count_since(const struct loop_count *start) {
  struct loop_count now = loop_count_now();
  now.minor_faults -= start->minor_faults;
  now.major_faults -= start->major_faults;
  if (now.allocations >= 0) now.allocations -= start->allocations;
  return now;
}
