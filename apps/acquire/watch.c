/* watch.c: once a second, and when the kernel says that an interface has changed. */
#define _GNU_SOURCE

#include "watch.h"

#include <string.h>
#include <unistd.h>

#include "clocks.h"

enum { LIVE_LINE = 400, NS_PER_S = 1000000000, NS_PER_TENTH = 100000000 };

void watch_push(struct session *s, const struct item *item) {
  ring_push(&s->events, item); /* far larger than what can come between two cycles of the writer */
}

void watch_clock(struct session *s) {
  const struct clock_triple now = clock_read_triple();
  struct item item = {.kind = ITEM_CLOCK, .real_ns = now.real_ns};
  item.is.number[0] = now.mono_ns;
  item.is.number[1] = now.real_ns;
  item.is.number[2] = now.raw_ns;
  item.is.number[3] = now.width_ns;
  watch_push(s, &item);
}

static struct item event(enum item_kind kind, int source) {
  struct item item;
  memset(&item, 0, sizeof item);
  item.kind = (uint8_t)kind;
  item.source = (uint8_t)source;
  item.real_ns = clock_real_ns();
  return item;
}

/* ---- interfaces ------------------------------------------------------------------- */

static void compare_presence(struct session *s, int i, const struct link_state *now) {
  const struct link_state *before = &s->link[i];
  struct item item = event(ITEM_LINK, i);
  if (!before->index != !now->index) {
    item.is.number[0] = now->index ? LINK_BACK : LINK_GONE;
    watch_push(s, &item);
  }
  if (now->index && before->up != now->up) {
    item.is.number[0] = now->up ? LINK_UP : LINK_DOWN;
    watch_push(s, &item);
  }
}

static void compare_counters(struct session *s, int i, const struct link_state *now) {
  if (now->index != s->link[i].index) return; /* another device under the same name counts from 0 */
  for (int c = 0; c < LINK_COUNTERS; c++) {
    const uint64_t more = now->counter[c] - s->link[i].counter[c];
    if (more == 0 || !link_counter_is_loss((enum link_counter)c)) continue;
    struct item item = event(ITEM_DROP, i);
    item.flags = ITEM_IN_INTERFACE;
    item.is.number[0] = (int64_t)more;
    item.is.number[1] = c;
    watch_push(s, &item);
  }
}

static void compare_bus(struct session *s, int i, const struct link_state *now) {
  if (now->bus.state == s->link[i].bus.state || !now->index) return;
  struct item item = event(ITEM_BUS_STATE, i);
  item.is.number[0] = now->bus.state;
  item.is.number[1] = now->bus.tx_errors;
  item.is.number[2] = now->bus.rx_errors;
  watch_push(s, &item);
}

static void push_stats(struct session *s, int i, const struct link_state *now) {
  struct item item = event(ITEM_STATS, i);
  for (int c = 0; c < LINK_COUNTERS; c++) item.is.number[c] = (int64_t)now->counter[c];
  watch_push(s, &item);
}

static void push_stamp_pair(struct session *s, int i) {
  struct item item = event(ITEM_HARDWARE, i);
  item.is.number[1] = __atomic_load_n(&s->source[i].pair_real_ns, __ATOMIC_ACQUIRE);
  item.is.number[0] = s->source[i].pair_hardware_ns;
  if (item.is.number[1]) watch_push(s, &item);
}

void watch_links(struct session *s, int report) {
  for (int i = 0; i < s->sources; i++) {
    struct link_state now;
    if (s->source[i].spec.kind != SOURCE_CAN) continue;
    if (link_query(s->netlink, s->source[i].spec.name, &now) != 0) continue;
    compare_presence(s, i, &now);
    compare_counters(s, i, &now);
    compare_bus(s, i, &now);
    if (report) push_stats(s, i, &now);
    if (s->source[i].hardware_stamps) push_stamp_pair(s, i);
    s->link[i] = now;
  }
}

/* ---- the live line ------------------------------------------------------------------ */

static void put_seconds(struct text *t, int64_t ns) {
  const int64_t tenths = ns / NS_PER_TENTH;
  text_whole(t, tenths / 10);
  text_string(t, ".");
  text_whole(t, tenths % 10);
  text_string(t, " s");
}

static void put_source(struct text *t, struct session *s, int i) {
  struct source *source = &s->source[i];
  const uint64_t seen = __atomic_load_n(&source->seen, __ATOMIC_RELAXED);
  if (text_room(t) < 100) return;
  text_string(t, "  ");
  text_string(t, source->spec.name);
  text_string(t, " ");
  text_whole(t, (int64_t)(seen - s->live_seen[i]));
  text_string(t, "/s");
  if (source->spec.kind == SOURCE_CAN && !s->link[i].up) {
    text_string(t, s->link[i].index ? " down" : " gone");
  } else if (s->link[i].bus.state != BUS_UNKNOWN && source->spec.kind == SOURCE_CAN) {
    text_string(t, " ");
    text_string(t, bus_state_name(s->link[i].bus.state));
  }
  s->live_seen[i] = seen;
}

/* a terminal that has gone is no reason to stop */
static void show(const char *text, size_t n) {
  if (write(STDERR_FILENO, text, n) < 0) return;
}

void watch_live_line(struct session *s) {
  char line[LIVE_LINE];
  struct text t = {line, 0, sizeof line - 8};
  uint64_t lost = 0;
  const int64_t now = clock_mono_ns();
  text_string(&t, "\r");
  put_seconds(&t, now - s->clock.start_ns);
  for (int i = 0; i < s->sources; i++) {
    put_source(&t, s, i);
    lost += s->source[i].lost;
  }
  text_string(&t, "  lost ");
  text_whole(&t, (int64_t)lost);
  if (s->settings->duration_s > 0.0) {
    text_string(&t, "  to go ");
    put_seconds(&t, s->clock.end_ns > now ? s->clock.end_ns - now : 0);
  }
  t.size = sizeof line; /* room that was kept for this: clears what is left of a longer line */
  text_string(&t, "\033[K");
  show(line, t.used);
}

void watch_live_end(void) {
  show("\n", 1);
}
