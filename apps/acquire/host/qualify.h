/* qualify.h: is this machine fit to record and to play? A thread wakes up each millisecond for minutes, as
 * cyclictest does, while the machine's settings and counters are looked at; each item gets a verdict.
 *
 *     qualify_begin(&q, &realtime);
 *     ... a recording, or just time ...
 *     qualify_end(&q, the recording's result or NULL);
 *     qualify_print(&q); qualify_write(&q, "Q.json", &error); qualify_free
 */
#ifndef QUALIFY_H
#define QUALIFY_H

#include <pthread.h>

#include "common/error.h"
#include "leg_bus/lateness.h"
#include "realtime.h"

enum verdict { VERDICT_GOOD, VERDICT_USABLE, VERDICT_POOR, VERDICT_UNKNOWN };
enum { QUALIFY_ITEMS = 16 };

struct qualify_item {
  const char *name;
  enum verdict verdict;
  char found[160];
  const char *advice; /* what would make it better; Nullable */
};

struct qualify {
  struct realtime realtime;
  pthread_t thread;
  int stop, warm;
  struct lateness late;    /* of the wake-ups */
  uint64_t missed;         /* whole periods that were slept through */
  int64_t largest_step_ns; /* of the realtime clock against the monotonic one, in one second */
  int64_t throttled;       /* times before the start; then those since; -1 not known */
  int64_t start_ns;
  double seconds;
  struct loop_count loop;
  struct qualify_item item[QUALIFY_ITEMS];
  int items;
};

/* Starts the thread. 0, or -1. */
int qualify_begin(struct qualify *q, int realtime, struct app_error *error);
/* For `seconds`, or until SIGINT or SIGTERM, when no session is run meanwhile. */
void qualify_wait(struct qualify *q, double seconds);
/* What was recorded meanwhile. */
struct qualify_recording {
  int sources;
  uint64_t lost;
  int lost_is_all; /* 0: there may be more */
  struct loop_count loop;
};
/* Ends the thread and judges. Nullable: recording. */
void qualify_end(struct qualify *q, const struct qualify_recording *recording);

void qualify_print(const struct qualify *q);
int qualify_write(const struct qualify *q, const char *path, struct app_error *error);

#endif
