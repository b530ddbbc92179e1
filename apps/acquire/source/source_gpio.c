/* source_gpio.c: edges of a line, the emergency stop, and a line that is driven. */
#define _GNU_SOURCE

#include <errno.h>
#include <string.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include "acquire/host/clocks.h"
#include "acquire/play/stop_line.h"
#include "source.h"

enum { EDGES = 64, NS_PER_S = 1000000000 };

/* Is the button pressed? It is at the level that its edge leads to; a line with both edges has no such level. */
static int read_button(struct source *s) {
  const enum gpio_edges edges = s->spec.line.edges;
  const int level = edges == GPIO_BOTH ? -1 : s->settings->gpio->get(s->gpio);
  return level < 0 ? -1 : level == (edges == GPIO_RISING);
}

static int open_line(struct source *s, struct app_error *error) {
  s->gpio = s->settings->gpio->open(&s->spec.line, error);
  if (!s->gpio) return -1;
  s->fd = s->settings->gpio->fd(s->gpio);
  if (s->spec.kind == SOURCE_ESTOP) s->pressed = read_button(s); /* edges are queued by now: none is missed */
  return 0;
}

/* ---- edges -------------------------------------------------------------------- */

/* sequence numbers count every edge of the line; a step above one is a gap in the kernel's queue */
static void report_gap(struct source *s, const struct gpio_edge *edge, int64_t now_ns) {
  const uint32_t missing = edge->sequence ? edge->sequence - s->sequence - 1 : 0;
  if (missing) {
    struct item item = {.kind = ITEM_EDGES_LOST, .source = s->index, .real_ns = now_ns};
    item.is.edges_lost.lost = missing;
    item.is.edges_lost.mono_ns = edge->mono_ns;
    source_add(&s->count.lost, missing);
    source_push(s, &item);
  }
  s->sequence = edge->sequence;
}

static void take_edge(struct source *s, const struct gpio_edge *edge, int64_t now_ns) {
  struct item item = {.kind = ITEM_EDGE, .source = s->index, .real_ns = now_ns};
  report_gap(s, edge, now_ns);
  item.is.edge.mono_ns = edge->mono_ns;
  item.is.edge.level = edge->value;
  item.is.edge.sequence = edge->sequence;
  source_add(&s->count.read, 1);
  source_add(&s->count.frames, 1);
  source_push(s, &item);
}

/* the stop comes first: writing it down can wait */
static void answer_emergency(struct source *s) {
  struct item item = {.kind = ITEM_STOP, .source = s->index};
  if (s->spec.kind != SOURCE_ESTOP || !s->settings->stop) return;
  stop_line_send(s->settings->stop, &item);
  __atomic_store_n(&s->stop_frames, item.is.stop.frames, __ATOMIC_RELAXED);
  __atomic_store_n(&s->stop_failure, item.is.stop.failure, __ATOMIC_RELAXED);
  __atomic_store_n(&s->stops, s->stops + 1, __ATOMIC_RELEASE);
  stop_line_tell(s->settings->stop);
  source_push(s, &item);
}

static int read_edges(struct source *s) {
  struct gpio_edge edge[EDGES];
  int n;
  const int64_t before = clock_real_ns();
  while ((n = s->settings->gpio->read(s->gpio, edge, EDGES)) > 0) {
    answer_emergency(s);
    for (int i = 0; i < n; i++) take_edge(s, &edge[i], clock_real_ns());
  }
  ring_set_watermark(&s->ring, before);
  return n;
}

static void finish_edges(struct source *s) {
  read_edges(s);
}

static void close_gpio(struct source *s) {
  if (s->gpio) s->settings->gpio->close(s->gpio);
  s->gpio = NULL;
  s->fd = -1;
}

/* ---- pulses ------------------------------------------------------------------- */

static int set_timer(struct source *s) {
  const struct itimerspec at = {.it_value = {s->next_ns / NS_PER_S, s->next_ns % NS_PER_S}};
  return timerfd_settime(s->fd, TFD_TIMER_ABSTIME, &at, NULL);
}

static int open_pulse(struct source *s, struct app_error *error) {
  if (open_line(s, error) != 0) return -1;
  s->fd = timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK);
  if (s->fd < 0) return app_fail(error, APP_FAILED, "%s: no timer: %s", s->spec.name, strerror(errno));
  s->next_ns = clock_mono_ns() + NS_PER_S / 10;
  set_timer(s);
  return 0;
}

static void drive(struct source *s, int value) {
  struct item item = {.kind = ITEM_PULSE, .source = s->index};
  const int64_t before = clock_mono_ns();
  s->settings->gpio->set(s->gpio, value);
  const int64_t after = clock_mono_ns();
  item.real_ns = clock_real_ns();
  item.is.pulse.mono_ns = before + (after - before) / 2;
  item.is.pulse.width_ns = after - before;
  item.is.pulse.level = value;
  s->value = value;
  source_add(&s->count.read, 1);
  source_add(&s->count.frames, 1);
  source_push(s, &item);
}

/* the next change keeps to the grid, whatever the last one's delay was */
static int run_pulse(struct source *s) {
  uint64_t expirations;
  const int64_t before = clock_real_ns();
  if (read(s->fd, &expirations, sizeof expirations) == (ssize_t)sizeof expirations) {
    const double high_ns = s->spec.high_s * NS_PER_S, period_ns = NS_PER_S / s->spec.rate_hz;
    drive(s, !s->value);
    s->next_ns += (int64_t)(s->value ? high_ns : period_ns - high_ns);
    set_timer(s);
  }
  ring_set_watermark(&s->ring, before);
  return 0;
}

static void finish_pulse(struct source *s) {
  if (s->value) drive(s, 0);
}

static void close_pulse(struct source *s) {
  if (s->fd >= 0) close(s->fd);
  close_gpio(s);
}

const struct source_ops source_gpio = {open_line, read_edges, finish_edges, close_gpio};
const struct source_ops source_pulse = {open_pulse, run_pulse, finish_pulse, close_pulse};
