/* realtime.h: what the machine lets us do so that nothing comes in between; each is asked for, and said
 * when refused. */
#ifndef REALTIME_H
#define REALTIME_H

#include <stdint.h>

enum { REALTIME_READER = 40, REALTIME_WRITER = 5, REALTIME_PLAYER = 60 };

/* What was had; reasons are errno, 0 where granted. */
struct realtime {
  int wanted;
  int lock_refused, fifo_refused, latency_refused;
  int latency_fd; /* held open: /dev/cpu_dma_latency at 0 */
};

/* What must not happen in the loop. */
struct loop_count {
  int64_t minor_faults, major_faults;
  int64_t allocations; /* -1: cannot be counted here */
};

/* Memory locked, the allocator told to give nothing back, deep processor sleep refused; tries the
 * scheduling class. Without `wanted` nothing is tried. */
void realtime_prepare(struct realtime *rt, int wanted);
void realtime_release(struct realtime *rt);

/* For the calling thread: its class and priority, and its stack's pages. */
void realtime_enter(const struct realtime *rt, int priority);

struct loop_count loop_count_now(void);
/* What has been added since. */
struct loop_count loop_count_since(const struct loop_count *start);

#endif
