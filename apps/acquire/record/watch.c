/* watch.c: once a second, and when the kernel says that an interface has changed. */
#define _GNU_SOURCE

#include "watch.h"

#include <errno.h>
#include <string.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include "acquire/host/clocks.h"

enum { EVENTS_RING = 1 << 10, LIVE_LINE = 400, NS_PER_TENTH = 100000000 };

/* A timer of the realtime clock that never ends, but is cancelled when the clock is set. */
static int open_clock_set(void) {
  const struct itimerspec never = {.it_value = {INT32_MAX, 0}};
  const int fd = timerfd_create(CLOCK_REALTIME, TFD_CLOEXEC | TFD_NONBLOCK);
  if (fd >= 0) timerfd_settime(fd, TFD_TIMER_ABSTIME | TFD_TIMER_CANCEL_ON_SET, &never, NULL);
  return fd;
}

int watch_open(struct watch *w, const struct source *source, int sources, struct stop_line *stop,
               struct app_error *error) {
  w->source = source;
  w->sources = sources;
  w->stop = stop;
  w->path_failure = -1;
  w->netlink = link_open(0);
  w->link_events = link_open(1);
  w->clock_set = open_clock_set();
  for (int i = 0; i < sources; i++) {
    w->link[i] = source[i].link;
    w->told[i].index = source[i].link.index;
    memcpy(w->told[i].counter, source[i].link.counter, sizeof w->told[i].counter);
  }
  return ring_init(&w->events, EVENTS_RING) == 0 ? 0 : app_fail(error, APP_FAILED, "out of memory");
}

void watch_close(struct watch *w) {
  if (w->netlink >= 0) close(w->netlink);
  if (w->link_events >= 0) close(w->link_events);
  if (w->clock_set >= 0) close(w->clock_set);
  ring_free(&w->events);
}

/* As a source does: waits where the ring is full because the disk holds up the writer. Emergency stops are told of meanwhile. */
static void push(struct watch *w, const struct item *item) {
  while (!ring_push(&w->events, item)) {
    watch_stops(w);
    if (source_wait_for_room(w->source)) continue;
    w->abandoned++;
    return;
  }
}

static struct item event(enum item_kind kind, int source) {
  struct item item;
  memset(&item, 0, sizeof item);
  item.kind = (uint8_t)kind;
  item.source = (uint8_t)source;
  item.real_ns = clock_real_ns();
  return item;
}

static void push_clock(struct watch *w, int is_set) {
  struct item item = event(ITEM_CLOCK, 0);
  item.is.clock = clock_read_triple();
  item.real_ns = item.is.clock.real_ns;
  item.flags = (uint8_t)is_set;
  push(w, &item);
}

void watch_clock(struct watch *w) {
  push_clock(w, 0);
}

void watch_clock_set(struct watch *w) {
  uint64_t expirations;
  const ssize_t n = read(w->clock_set, &expirations, sizeof expirations);
  if (n < 0 && errno == ECANCELED) push_clock(w, 1);
}

/* ---- interfaces ------------------------------------------------------------------- */

static void push_change(struct watch *w, int i, enum link_change change, const struct link_state *now) {
  struct item item = event(ITEM_LINK, i);
  item.is.link.change = (int)change;
  item.is.link.index = now->index;
  memcpy(item.is.link.name, now->name, sizeof item.is.link.name);
  push(w, &item);
}

/* the one that was recorded until now, still there under another name? */
static int has_another_name(struct watch *w, int index) {
  struct link_state old;
  return link_query_index(w->netlink, index, &old) == 0 && old.index == index;
}

static void compare_presence(struct watch *w, int i, const struct link_state *now) {
  const struct link_state *before = &w->link[i];
  const int another = now->index != before->index;
  if (another && before->index) {
    const int replaced = now->index && has_another_name(w, before->index);
    push_change(w, i, replaced ? LINK_REPLACED : LINK_GONE, replaced ? now : before);
  }
  if (another && now->index) push_change(w, i, LINK_BACK, now);
  if (!another && now->index && strcmp(now->name, before->name) != 0) push_change(w, i, LINK_RENAMED, now);
  if (now->index && (another ? now->up : before->up != now->up))
    push_change(w, i, now->up ? LINK_UP : LINK_DOWN, now);
}

/* against what was told of that interface before; of another one it is what its first event has said */
static void compare_counters(struct watch *w, int i, const struct link_state *now) {
  struct link_told *told = &w->told[i];
  const struct link_told before = *told;
  *told = (struct link_told){.index = now->index};
  memcpy(told->counter, now->counter, sizeof told->counter);
  for (int c = 0; c < LINK_COUNTERS && now->index == before.index; c++) {
    const uint64_t more = now->counter[c] - before.counter[c];
    if (more == 0 || !link_counter_is_loss((enum link_counter)c)) continue;
    struct item item = event(ITEM_DROP, i);
    item.is.drop.lost = more;
    item.is.drop.where = ITEM_IN_INTERFACE;
    item.is.drop.counter = c;
    push(w, &item);
  }
}

static void compare_bus(struct watch *w, int i, const struct link_state *now) {
  if (now->bus.state == w->link[i].bus.state || !now->index) return;
  struct item item = event(ITEM_BUS_STATE, i);
  item.is.bus.state = (int)now->bus.state;
  item.is.bus.tx_errors = now->bus.tx_errors;
  item.is.bus.rx_errors = now->bus.rx_errors;
  push(w, &item);
}

static void push_stats(struct watch *w, int i, const struct link_state *now) {
  struct item item = event(ITEM_STATS, i);
  memcpy(item.is.counter, now->counter, sizeof item.is.counter);
  push(w, &item);
}

static void push_stamp_pair(struct watch *w, int i) {
  struct item item = event(ITEM_HARDWARE, i);
  if (stamp_pair_read(&w->source[i].pair, &item.is.stamps.hardware_ns, &item.is.stamps.real_ns))
    push(w, &item);
}

/* the interface of that name; where nothing has it, the one that had it last and has another name now */
static int look(struct watch *w, int i, struct link_state *now) {
  if (link_query(w->netlink, w->source[i].spec.name, now) != 0) return -1;
  if (now->index || !w->link[i].index) return 0;
  return link_query_index(w->netlink, w->link[i].index, now);
}

/* ---- the emergency stop --------------------------------------------------------------- */

static void watch_stop_path(struct watch *w) {
  if (!w->stop) return;
  const int failure = stop_line_path(w->stop, w->netlink);
  if (failure == w->path_failure) return;
  struct item item = event(ITEM_STOP_PATH, 0);
  item.is.stop_path.ready = failure == 0;
  item.is.stop_path.failure = failure;
  push(w, &item);
  if (failure)
    app_note("an emergency stop CANNOT BE SENT on %s now: %s", w->stop->port.name, strerror(failure));
  else if (w->path_failure >= 0)
    app_note("an emergency stop can be sent on %s again", w->stop->port.name);
  w->path_failure = failure;
}

static void tell_stop(const struct watch *w, const struct source *source) {
  const int frames = __atomic_load_n(&source->stop_frames, __ATOMIC_RELAXED);
  const int failure = __atomic_load_n(&source->stop_failure, __ATOMIC_RELAXED);
  if (frames == 0)
    app_note("%s: EMERGENCY STOP NOT SENT on %s: %s", source->spec.name, w->stop->port.name,
             strerror(failure));
  else if (frames < STOP_FRAMES)
    app_note("%s: EMERGENCY STOP SENT ONLY IN PART on %s, %d of %d frames: %s", source->spec.name,
             w->stop->port.name, frames, STOP_FRAMES, strerror(failure));
  else
    app_note("%s: emergency stop sent on %s, %d of %d frames", source->spec.name, w->stop->port.name, frames,
             STOP_FRAMES);
}

void watch_stops(struct watch *w) {
  uint64_t woken;
  if (!w->stop || read(w->stop->told, &woken, sizeof woken) < 0) return;
  for (int i = 0; i < w->sources; i++) {
    const uint64_t stops = __atomic_load_n(&w->source[i].stops, __ATOMIC_ACQUIRE);
    if (stops != w->stops_told[i]) tell_stop(w, &w->source[i]);
    w->stops_told[i] = stops;
  }
}

/* ---- all of it ------------------------------------------------------------------------- */

void watch_links(struct watch *w, int report) {
  for (int i = 0; i < w->sources; i++) {
    struct link_state now;
    if (w->source[i].spec.kind != SOURCE_CAN || look(w, i, &now) != 0) continue;
    compare_presence(w, i, &now);
    if (now.index) compare_counters(w, i, &now);
    compare_bus(w, i, &now);
    if (report) push_stats(w, i, &now);
    if (w->source[i].hardware_stamps) push_stamp_pair(w, i);
    w->link[i] = now;
  }
  watch_stop_path(w);
}

static int concerns(const struct watch *w, int i, const struct link_event *event) {
  const struct link_state *now = &event->now;
  if (w->source[i].spec.kind != SOURCE_CAN || !now->is_can) return 0;
  if (event->gone) return now->index == w->told[i].index;
  return now->index != w->told[i].index && strcmp(now->name, w->source[i].spec.name) == 0;
}

/* events were lost: what an interface had counted that is gone by now is not known */
static void look_for_the_vanished(struct watch *w, int i) {
  struct link_state now;
  if (w->source[i].spec.kind != SOURCE_CAN) return;
  if (link_query_index(w->netlink, w->told[i].index, &now) == 0 && now.index) return;
  struct item item = event(ITEM_VANISHED, i);
  item.is.vanished.index = w->told[i].index;
  item.is.vanished.unknown = 1;
  push(w, &item);
}

/* the counters of an interface that has come, and the last ones of one that is gone; the rest is asked for */
void watch_link_events(struct watch *w) {
  struct link_event event;
  for (int n; (n = link_next_event(w->link_events, &event)) != 0;)
    for (int i = 0; i < w->sources; i++) {
      if (n > 0 && concerns(w, i, &event)) compare_counters(w, i, &event.now);
      if (n < 0) look_for_the_vanished(w, i);
    }
  watch_links(w, 0);
}

/* ---- the live line ------------------------------------------------------------------ */

static void put_seconds(struct text *t, int64_t ns) {
  const int64_t tenths = ns / NS_PER_TENTH;
  text_whole(t, tenths / 10);
  text_string(t, ".");
  text_whole(t, tenths % 10);
  text_string(t, " s");
}

static void put_source(struct text *t, struct watch *w, int i) {
  const struct source *source = &w->source[i];
  const uint64_t seen = source_count(&source->count.frames);
  if (text_room(t) < 100) return;
  text_string(t, "  ");
  text_string(t, source->spec.name);
  text_string(t, " ");
  text_whole(t, (int64_t)(seen - w->live_seen[i]));
  text_string(t, "/s");
  if (source->spec.kind == SOURCE_CAN && !w->link[i].up) {
    text_string(t, w->link[i].index ? " down" : " gone");
  } else if (w->link[i].bus.state != BUS_UNKNOWN && source->spec.kind == SOURCE_CAN) {
    text_string(t, " ");
    text_string(t, bus_state_name(w->link[i].bus.state));
  }
  w->live_seen[i] = seen;
}

/* a terminal that has gone is no reason to stop */
static void show(const char *text, size_t n) {
  if (write(STDERR_FILENO, text, n) < 0) return;
}

void watch_live_line(struct watch *w) {
  char line[LIVE_LINE];
  struct text t = {line, 0, sizeof line - 8};
  uint64_t lost = 0;
  const int64_t now = clock_mono_ns();
  text_string(&t, "\r");
  put_seconds(&t, now - w->start_ns);
  for (int i = 0; i < w->sources; i++) {
    put_source(&t, w, i);
    lost += source_count(&w->source[i].count.lost);
  }
  text_string(&t, "  lost ");
  text_whole(&t, (int64_t)lost);
  if (w->end_ns) {
    text_string(&t, "  to go ");
    put_seconds(&t, w->end_ns > now ? w->end_ns - now : 0);
  }
  t.size = sizeof line; /* room that was kept for this: clears what is left of a longer line */
  text_string(&t, "\033[K");
  show(line, t.used);
}

void watch_live_end(void) {
  show("\n", 1);
}
