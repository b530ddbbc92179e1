/* qualify.c: the thread that measures, and the verdicts. */
#define _GNU_SOURCE

#include "qualify.h"

#include <errno.h>
#include <inttypes.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/utsname.h>
#include <time.h>

#include "clocks.h"
#include "common/json_file.h"
#include "machine.h"
#include "talus/version.h"

enum { PERIOD_NS = 1000000, NS_PER_S = 1000000000, PRIORITY = 80, STACK = 512 << 10, STEP_NS = 1000000 };
static const char throttle_count[] = "thermal_throttle/core_throttle_count";

/* ---- the thread ---------------------------------------------------------------------------- */

static void *measure(void *argument) {
  struct qualify *q = argument;
  realtime_enter(&q->realtime, PRIORITY);
  int64_t due = clock_mono_ns() + PERIOD_NS, second = due, offset = clock_real_ns() - clock_mono_ns();
  __atomic_store_n(&q->warm, 1, __ATOMIC_RELEASE);
  while (!__atomic_load_n(&q->stop, __ATOMIC_ACQUIRE)) {
    clock_sleep_until(due);
    const int64_t now = clock_mono_ns(), missed = (now - due) / PERIOD_NS;
    lateness_add(&q->late, now - due, PERIOD_NS);
    q->missed += (uint64_t)missed;
    due += (1 + missed) * PERIOD_NS;
    if (now - second < NS_PER_S) continue;
    second = now;
    const int64_t then = offset, step = (offset = clock_real_ns() - clock_mono_ns()) - then;
    const int64_t size = step < 0 ? -step : step;
    if (size > q->largest_step_ns) q->largest_step_ns = size;
  }
  return NULL;
}

int qualify_begin(struct qualify *q, int realtime, struct app_error *error) {
  pthread_attr_t attributes;
  memset(q, 0, sizeof *q);
  realtime_prepare(&q->realtime, realtime);
  q->throttled = machine_cpu_sum(throttle_count);
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, STACK);
  const int failure = pthread_create(&q->thread, &attributes, measure, q);
  pthread_attr_destroy(&attributes);
  if (failure) return app_fail(error, APP_FAILED, "a thread cannot be started: %s", strerror(failure));
  while (!__atomic_load_n(&q->warm, __ATOMIC_ACQUIRE)) clock_sleep_until(clock_mono_ns() + PERIOD_NS);
  q->start_ns = clock_mono_ns();
  q->loop = loop_count_now();
  return 0;
}

void qualify_wait(struct qualify *q, double seconds) {
  const struct timespec t = {(time_t)seconds, (long)((seconds - (double)(time_t)seconds) * NS_PER_S)};
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  sigprocmask(SIG_BLOCK, &set, NULL);
  q->loop = loop_count_now();
  while (sigtimedwait(&set, NULL, &t) < 0 && errno == EINTR) continue;
}

/* ---- verdicts ------------------------------------------------------------------------------- */

static void judge(struct qualify *q, const char *name, enum verdict verdict, const char *advice,
                  const char *format, ...) APP_PRINTF(5, 6);

static void judge(struct qualify *q, const char *name, enum verdict verdict, const char *advice,
                  const char *format, ...) {
  struct qualify_item *item = &q->item[q->items++];
  va_list arguments;
  item->name = name;
  item->verdict = verdict;
  item->advice = verdict == VERDICT_GOOD ? NULL : advice;
  va_start(arguments, format);
  vsnprintf(item->found, sizeof item->found, format, arguments);
  va_end(arguments);
}

static void judge_privileges(struct qualify *q) {
  const struct realtime *rt = &q->realtime;
  const char *asked = rt->wanted ? NULL : "not asked for (--no-realtime)";
  judge(q, "priority", !asked && !rt->fifo_refused ? VERDICT_GOOD : VERDICT_POOR,
        "allow it: rtprio in /etc/security/limits.conf, or CAP_SYS_NICE", "SCHED_FIFO: %s",
        asked              ? asked
        : rt->fifo_refused ? strerror(rt->fifo_refused)
                           : "granted");
  judge(q, "memory", !asked && !rt->lock_refused ? VERDICT_GOOD : VERDICT_POOR,
        "allow it: memlock unlimited in /etc/security/limits.conf, or CAP_IPC_LOCK", "locked memory: %s",
        asked              ? asked
        : rt->lock_refused ? strerror(rt->lock_refused)
                           : "granted");
  judge(q, "sleep", !asked && !rt->latency_refused ? VERDICT_GOOD : VERDICT_USABLE,
        "make /dev/cpu_dma_latency writable for the user", "deep processor sleep: %s",
        asked                 ? asked
        : rt->latency_refused ? strerror(rt->latency_refused)
                              : "held off");
}

static void judge_kernel(struct qualify *q) {
  struct utsname kernel;
  memset(&kernel, 0, sizeof kernel);
  uname(&kernel);
  const int realtime = machine_number("/sys/kernel/realtime", 0) == 1;
  judge(q, "kernel", realtime ? VERDICT_GOOD : VERDICT_USABLE,
        "a PREEMPT_RT kernel (Debian: linux-image-rt-amd64)", "%.60s%s", kernel.release,
        realtime ? ", PREEMPT_RT" : ", not PREEMPT_RT");
}

static void judge_clock(struct qualify *q) {
  static const char *const steady[] = {"tsc", "arch_sys_counter", "kvm-clock"};
  char name[64] = "not known";
  int good = 0;
  machine_line("/sys/devices/system/clocksource/clocksource0/current_clocksource", name, sizeof name);
  for (int i = 0; i < 3; i++) good |= strcmp(name, steady[i]) == 0;
  judge(q, "clock", good ? VERDICT_GOOD : VERDICT_USABLE, "clocksource=tsc, where the processor's is steady",
        "%s", name);
  judge(q, "clock steps", q->largest_step_ns < STEP_NS ? VERDICT_GOOD : VERDICT_POOR,
        "let NTP slew the clock, and set it before measuring",
        "realtime against monotonic: at most %.1f us in a second", 1e-3 * (double)q->largest_step_ns);
}

static void judge_processors(struct qualify *q) {
  int there, equal;
  machine_cpu_count("cpufreq/scaling_governor", "performance", &there, &equal);
  if (there)
    judge(q, "governor", there == equal ? VERDICT_GOOD : VERDICT_USABLE,
          "set every processor's governor to performance", "performance on %d of %d processors", equal,
          there);
  else
    judge(q, "governor", VERDICT_UNKNOWN, NULL, "no frequency control to be seen");
  const int64_t now = machine_cpu_sum(throttle_count);
  if (now >= 0 && q->throttled >= 0) q->throttled = now - q->throttled;
  if (q->throttled < 0)
    judge(q, "throttling", VERDICT_UNKNOWN, NULL, "no counters to be seen");
  else
    judge(q, "throttling", q->throttled ? VERDICT_POOR : VERDICT_GOOD, "cool the machine",
          "%" PRId64 " times for heat", q->throttled);
}

static void judge_run(struct qualify *q, const struct qualify_recording *recording) {
  const double worst_us = 1e-3 * (double)q->late.worst_ns;
  const enum verdict latency = worst_us < 200.0    ? VERDICT_GOOD
                               : worst_us < 1000.0 ? VERDICT_USABLE
                                                   : VERDICT_POOR;
  judge(q, "wake-up", latency, "see the items above; try again under the load that the bench will have",
        "%lu wake-ups at 1 kHz: half below %.0f us, 99.9 %% below %.0f us, worst %.1f us, %" PRIu64
        " periods missed",
        q->late.ticks, lateness_quantile_us(&q->late, 0.5), lateness_quantile_us(&q->late, 0.999), worst_us,
        q->missed);
  const int clean = q->loop.minor_faults + q->loop.major_faults == 0 && q->loop.allocations <= 0;
  judge(q, "loop", clean ? VERDICT_GOOD : VERDICT_POOR, "lock memory",
        "page faults %" PRId64 " minor, %" PRId64 " major; allocations %" PRId64, q->loop.minor_faults,
        q->loop.major_faults, q->loop.allocations);
  if (!recording) {
    judge(q, "drops", VERDICT_UNKNOWN, "name the interfaces, while the bench sends",
          "no interface was recorded");
    return;
  }
  judge(q, "drops",
        recording->lost          ? VERDICT_POOR
        : recording->lost_is_all ? VERDICT_GOOD
                                 : VERDICT_UNKNOWN,
        "a larger --buffer, a quieter machine", "%d sources recorded, %" PRIu64 " lost%s", recording->sources,
        recording->lost,
        recording->lost_is_all ? "" : "; an interface vanished, and perhaps more were lost then");
}

void qualify_end(struct qualify *q, const struct qualify_recording *recording) {
  q->loop = recording ? recording->loop : loop_count_since(&q->loop);
  q->seconds = 1e-9 * (double)(clock_mono_ns() - q->start_ns);
  __atomic_store_n(&q->stop, 1, __ATOMIC_RELEASE);
  pthread_join(q->thread, NULL);
  judge_kernel(q);
  judge_privileges(q);
  judge_clock(q);
  judge_processors(q);
  judge_run(q, recording);
  realtime_release(&q->realtime);
}

/* ---- report --------------------------------------------------------------------------------- */

static const char *verdict_name(enum verdict verdict) {
  static const char *const name[] = {"good", "usable", "poor", "unknown"};
  return name[verdict];
}

void qualify_print(const struct qualify *q) {
  printf("%.0f s on this machine\n", q->seconds);
  for (int i = 0; i < q->items; i++) {
    const struct qualify_item *item = &q->item[i];
    printf("%-8s %-12s %s\n", verdict_name(item->verdict), item->name, item->found);
    if (item->advice) printf("%22s-> %s\n", "", item->advice);
  }
}

static json_t *histogram(const struct lateness *late) {
  json_t *object = json_object();
  for (int k = 0; k < LATENESS_CLASSES; k++) {
    char edge_us[24];
    if (!late->count[k]) continue;
    snprintf(edge_us, sizeof edge_us, "%" PRId64, (int64_t)1 << k);
    json_object_set_new(object, edge_us, json_integer((json_int_t)late->count[k]));
  }
  return object;
}

static json_t *wake_ups(const struct qualify *q) {
  json_t *object = json_object();
  json_object_set_new(object, "period_us", json_integer(PERIOD_NS / 1000));
  json_object_set_new(object, "count", json_integer((json_int_t)q->late.ticks));
  json_object_set_new(object, "missed", json_integer((json_int_t)q->missed));
  json_object_set_new(object, "worst_ns", json_integer(q->late.worst_ns));
  json_object_set_new(object, "late_below_us", histogram(&q->late));
  return object;
}

static json_t *loop(const struct loop_count *count) {
  json_t *object = json_object();
  json_object_set_new(object, "page_faults_minor", json_integer(count->minor_faults));
  json_object_set_new(object, "page_faults_major", json_integer(count->major_faults));
  json_object_set_new(object, "allocations",
                      count->allocations < 0 ? json_null() : json_integer(count->allocations));
  return object;
}

int qualify_write(const struct qualify *q, const char *path, struct app_error *error) {
  json_t *root = json_object(), *items = json_array();
  json_set_text(root, "schema", "talus-qualify/1");
  json_set_text(root, "version", tl_version());
  json_set_number(root, "seconds", q->seconds);
  for (int i = 0; i < q->items; i++) {
    json_t *item = json_object();
    json_set_text(item, "name", q->item[i].name);
    json_set_text(item, "verdict", verdict_name(q->item[i].verdict));
    json_set_text(item, "found", q->item[i].found);
    if (q->item[i].advice) json_set_text(item, "advice", q->item[i].advice);
    json_array_append_new(items, item);
  }
  json_object_set_new(root, "items", items);
  json_object_set_new(root, "wake_ups", wake_ups(q));
  json_object_set_new(root, "loop", loop(&q->loop));
  const int result = json_file_write(path, root, error);
  json_decref(root);
  return result;
}
