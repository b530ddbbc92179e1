/* writer.c: rings to lines.
 *
 * Between interfaces, lines stand in the order of their stamps. A source says up to which time everything has
 * been put into its ring; what is later than the slowest source's word waits, but for HOLD_CYCLES at most.
 */
#include "writer.h"

#include <linux/can.h>
#include <string.h>

#include "acquire/host/clocks.h"
#include "can_text.h"

enum { HOLD_CYCLES = 3, LINE_ROOM = 1024, ERROR_FOLD_NS = 100000000 };

void writer_init(struct writer *w, struct file_pair *files, struct source *source, int sources,
                 struct ring *events) {
  memset(w, 0, sizeof *w);
  w->files = files;
  w->source = source;
  w->sources = sources;
  w->events = events;
  for (int i = 0; i < sources; i++) w->state[i].bus = source[i].link.bus;
}

static struct text *json(struct writer *w) {
  return &w->files->file[FILE_JSON].text;
}

/* ---- lines ------------------------------------------------------------------------ */

static void begin(struct writer *w, const char *type, int source) {
  text_begin(json(w), type);
  text_set_string(json(w), "source", w->source[source].spec.name);
}

static void end_at(struct writer *w, uint64_t after, int64_t real_ns) {
  text_set(json(w), "after", (int64_t)after);
  text_set(json(w), "real_ns", real_ns);
  text_end(json(w));
}

static void put_bus_state(struct writer *w, int source, int64_t real_ns, const char *by) {
  const struct written *s = &w->state[source];
  begin(w, "bus_state", source);
  text_set_string(json(w), "state", bus_state_name(s->bus.state));
  if (s->bus.tx_errors >= 0) {
    text_set(json(w), "tx_errors", s->bus.tx_errors);
    text_set(json(w), "rx_errors", s->bus.rx_errors);
  }
  text_set_string(json(w), "by", by);
  end_at(w, s->frames, real_ns);
}

/* the error frames that were counted together */
static void put_errors(struct writer *w, int source) {
  struct written *s = &w->state[source];
  char hex[2 * CAN_MAX_DLEN + 1] = "";
  const uint8_t id[] = {(uint8_t)(s->error.id >> 24), (uint8_t)(s->error.id >> 16),
                        (uint8_t)(s->error.id >> 8), (uint8_t)s->error.id};
  if (s->error_count == 0) return;
  begin(w, "error", source);
  hex[can_text_hex(hex, id, sizeof id)] = '\0';
  text_set_string(json(w), "id", hex);
  hex[can_text_hex(hex, s->error.is.data, CAN_MAX_DLEN)] = '\0';
  text_set_string(json(w), "data", hex);
  text_set(json(w), "count", (int64_t)s->error_count);
  text_set(json(w), "last_ns", s->error_last_ns);
  end_at(w, s->error_after, s->error.real_ns);
  s->error_count = 0;
}

static void put_error(struct writer *w, const struct item *item) {
  struct written *s = &w->state[item->source];
  const int same = s->error_count && s->error_after == s->frames && s->error.id == item->id &&
                   memcmp(s->error.is.data, item->is.data, CAN_MAX_DLEN) == 0 &&
                   (uint64_t)item->real_ns - (uint64_t)s->error.real_ns < ERROR_FOLD_NS;
  s->errors++;
  if (!same) {
    put_errors(w, item->source);
    s->error = *item;
    s->error_after = s->frames;
  }
  s->error_count++;
  s->error_last_ns = item->real_ns;
  if (bus_says_overflow(item->id, item->is.data)) s->lost[ITEM_IN_INTERFACE]++;
  if (bus_fold(&s->bus, item->id, item->is.data)) {
    put_errors(w, item->source);
    put_bus_state(w, item->source, item->real_ns, "error_frame");
  }
}

/* One clock for all frames of an adapter: what it did not stamp itself (what this machine sent) gets the kernel's stamp, moved
 * onto its clock. */
static int64_t hardware_stamp(struct written *s, const struct item *item) {
  if (item->hardware_ns) {
    s->to_hardware_ns = (int64_t)((uint64_t)item->hardware_ns - (uint64_t)item->real_ns);
    return item->hardware_ns;
  }
  s->estimated++;
  return (int64_t)((uint64_t)item->real_ns + (uint64_t)s->to_hardware_ns);
}

static void put_frame(struct writer *w, const struct item *item) {
  struct written *s = &w->state[item->source];
  const struct source *source = &w->source[item->source];
  struct text *log = &w->files->file[FILE_LOG].text;
  const int64_t stamp = source->hardware_stamps ? hardware_stamp(s, item) : item->real_ns;
  log->used += can_text_line(log->at + log->used, item, stamp, source->spec.name);
  s->backwards += stamp < s->last_ns;
  s->last_ns = stamp;
  w->out_of_order += item->real_ns < w->last_ns;
  w->last_ns = item->real_ns;
  s->frames++;
}

static void put_drop(struct writer *w, const struct item *item) {
  struct written *s = &w->state[item->source];
  s->lost[item->is.drop.where] += item->is.drop.lost;
  begin(w, "drop", item->source);
  text_set_string(json(w), "where", item->is.drop.where == ITEM_IN_SOCKET ? "socket" : "interface");
  if (item->is.drop.where == ITEM_IN_INTERFACE)
    text_set_string(json(w), "counter", link_counter_name((enum link_counter)item->is.drop.counter));
  text_set(json(w), "lost", (int64_t)item->is.drop.lost);
  end_at(w, s->frames, item->real_ns);
}

static void put_link(struct writer *w, const struct item *item) {
  begin(w, "link", item->source);
  text_set_string(json(w), "state", link_change_name((enum link_change)item->is.link.change));
  text_set(json(w), "interface", item->is.link.index);
  text_set_string(json(w), "name", item->is.link.name);
  end_at(w, w->state[item->source].frames, item->real_ns);
}

/* what it had counted, and how much of it nobody has read */
static void put_vanished(struct writer *w, const struct item *item) {
  struct written *s = &w->state[item->source];
  s->lost[ITEM_IN_INTERFACE] += item->is.vanished.lost;
  s->perhaps_lost += item->is.vanished.more;
  s->not_known += item->is.vanished.unknown != 0;
  begin(w, "vanished", item->source);
  text_set(json(w), "interface", item->is.vanished.index);
  text_set(json(w), "received", (int64_t)item->is.vanished.received);
  text_set(json(w), "read", (int64_t)item->is.vanished.read);
  text_set(json(w), "lost", (int64_t)item->is.vanished.lost);
  text_set(json(w), "perhaps_lost", (int64_t)item->is.vanished.more);
  text_set_bool(json(w), "known", !item->is.vanished.unknown);
  end_at(w, s->frames, item->real_ns);
}

/* asked for each second; mostly error frames have said it before */
static void put_driver_state(struct writer *w, const struct item *item) {
  struct bus *known = &w->state[item->source].bus;
  const enum bus_state now = (enum bus_state)item->is.bus.state;
  if (known->state == now || (known->state == BUS_RESTARTED && now == BUS_ACTIVE)) return;
  *known = (struct bus){now, item->is.bus.tx_errors, item->is.bus.rx_errors};
  put_bus_state(w, item->source, item->real_ns, "driver");
}

static void put_stats(struct writer *w, const struct item *item) {
  begin(w, "stats", item->source);
  text_set(json(w), "frames", (int64_t)w->state[item->source].frames);
  for (int i = 0; i < LINK_COUNTERS; i++)
    text_set(json(w), link_counter_name((enum link_counter)i), (int64_t)item->is.counter[i]);
  text_set(json(w), "real_ns", item->real_ns);
  text_end(json(w));
}

/* ---- GPIO and clocks ---------------------------------------------------------------- */

static void put_level(struct writer *w, const struct item *item, const char *type, int level,
                      int64_t mono_ns) {
  begin(w, type, item->source);
  text_set(json(w), "value", level);
  text_set(json(w), "mono_ns", mono_ns);
}

static void put_edge(struct writer *w, const struct item *item) {
  put_level(w, item, "edge", item->is.edge.level, item->is.edge.mono_ns);
  text_set(json(w), "sequence", item->is.edge.sequence);
  text_end(json(w));
  w->state[item->source].edges++;
}

static void put_pulse(struct writer *w, const struct item *item) {
  put_level(w, item, "pulse", item->is.pulse.level, item->is.pulse.mono_ns);
  text_set(json(w), "width_ns", item->is.pulse.width_ns);
  text_end(json(w));
  w->state[item->source].pulses++;
}

static void put_edges_lost(struct writer *w, const struct item *item) {
  struct written *s = &w->state[item->source];
  s->lost[ITEM_IN_SOCKET] += item->is.edges_lost.lost;
  begin(w, "edges_lost", item->source);
  text_set(json(w), "lost", (int64_t)item->is.edges_lost.lost);
  text_set(json(w), "after", (int64_t)s->edges);
  text_set(json(w), "mono_ns", item->is.edges_lost.mono_ns);
  text_end(json(w));
}

static void put_stop(struct writer *w, const struct item *item) {
  struct written *s = &w->state[item->source];
  s->stops.all++;
  s->stops.failed += item->is.stop.frames == 0;
  s->stops.partial += item->is.stop.frames > 0 && item->is.stop.failure != 0;
  begin(w, "stop", item->source);
  text_set_bool(json(w), "sent", item->is.stop.frames > 0);
  text_set(json(w), "frames", item->is.stop.frames);
  text_set(json(w), "errno", item->is.stop.failure);
  text_set(json(w), "attempts", item->is.stop.attempts);
  text_set(json(w), "mono_ns", item->is.stop.mono_ns);
  text_end(json(w));
}

static void put_stop_path(struct writer *w, const struct item *item) {
  text_begin(json(w), "stop_path");
  text_set_bool(json(w), "ready", item->is.stop_path.ready);
  text_set(json(w), "errno", item->is.stop_path.failure);
  text_set(json(w), "real_ns", item->real_ns);
  text_end(json(w));
}

static void put_clock(struct writer *w, const struct item *item) {
  text_begin(json(w), "clock");
  text_set(json(w), "mono_ns", item->is.clock.mono_ns);
  text_set(json(w), "real_ns", item->is.clock.real_ns);
  text_set(json(w), "raw_ns", item->is.clock.raw_ns);
  text_set(json(w), "width_ns", item->is.clock.width_ns);
  if (item->flags) text_set_bool(json(w), "set", 1);
  text_end(json(w));
}

static void put_hardware(struct writer *w, const struct item *item) {
  begin(w, "hardware_clock", item->source);
  text_set(json(w), "hw_ns", item->is.stamps.hardware_ns);
  text_set(json(w), "real_ns", item->is.stamps.real_ns);
  text_end(json(w));
}

static void put(struct writer *w, const struct item *item) {
  switch ((enum item_kind)item->kind) {
  case ITEM_FRAME: put_frame(w, item); break;
  case ITEM_ERROR: put_error(w, item); break;
  case ITEM_DROP: put_drop(w, item); break;
  case ITEM_LINK: put_link(w, item); break;
  case ITEM_VANISHED: put_vanished(w, item); break;
  case ITEM_BUS_STATE: put_driver_state(w, item); break;
  case ITEM_EDGE: put_edge(w, item); break;
  case ITEM_PULSE: put_pulse(w, item); break;
  case ITEM_EDGES_LOST: put_edges_lost(w, item); break;
  case ITEM_STOP: put_stop(w, item); break;
  case ITEM_STOP_PATH: put_stop_path(w, item); break;
  case ITEM_CLOCK: put_clock(w, item); break;
  case ITEM_HARDWARE: put_hardware(w, item); break;
  case ITEM_STATS: put_stats(w, item); break;
  }
}

/* ---- order -------------------------------------------------------------------------- */

/* rings are counted through: the sources', and behind them the events' */
static struct ring *ring_of(struct writer *w, int i) {
  return i < w->sources ? &w->source[i].ring : w->events;
}

static uint32_t *old_head(struct writer *w, int i) {
  return i < w->sources ? &w->state[i].old_head : &w->events_old;
}

/* up to when every source has given all it has */
static int64_t settled_until(struct writer *w) {
  int64_t least = INT64_MAX;
  for (int i = 0; i < w->sources; i++) {
    const int64_t mark = ring_watermark(&w->source[i].ring);
    if (mark < least) least = mark;
  }
  return least;
}

/* the ring whose oldest item is the earliest of all that may be written, or -1 */
static int choose(struct writer *w, int64_t until, int all) {
  int chosen = -1;
  int64_t earliest = INT64_MAX;
  for (int i = 0; i <= w->sources; i++) {
    struct ring *r = ring_of(w, i);
    if (ring_filled(r) == 0) continue;
    const int64_t at = ring_peek(r, 0)->real_ns;
    const int overdue = (int32_t)(*old_head(w, i) - r->tail) > 0 || ring_filled(r) > r->size / 2;
    if ((all || overdue || at <= until) && (chosen < 0 || at < earliest)) {
      earliest = at;
      chosen = i;
    }
  }
  return chosen;
}

/* every HOLD_CYCLES: what is in the rings now is overdue when we come by again */
static void note_heads(struct writer *w) {
  if (++w->cycle % HOLD_CYCLES != 0) return;
  for (int i = 0; i <= w->sources; i++) {
    struct ring *r = ring_of(w, i);
    const uint32_t filled = ring_filled(r);
    *old_head(w, i) = r->tail + filled;
    if (filled > r->most) r->most = filled;
  }
}

/* the disk has refused: lines that are in no file are not counted as written */
static void take_back(struct writer *w) {
  struct text *log = &w->files->file[FILE_LOG].text;
  const char *end = log->at + log->used;
  for (const char *line = log->at; line < end;
       line = (const char *)memchr(line, '\n', (size_t)(end - line)) + 1) {
    const char *name = (const char *)memchr(line, ' ', (size_t)(end - line)) + 1;
    for (int i = 0; i < w->sources; i++) {
      const size_t n = strlen(w->source[i].spec.name);
      if (memcmp(name, w->source[i].spec.name, n) != 0 || name[n] != ' ') continue;
      w->state[i].frames--;
      w->state[i].not_written++;
    }
  }
  log->used = 0;
}

/* what the next sync may count on */
static void note_handed(struct writer *w) {
  for (int i = 0; i < w->sources; i++)
    __atomic_store_n(&w->state[i].handed, w->state[i].frames, __ATOMIC_RELEASE);
}

static int flush_all(struct writer *w) {
  const int log = file_pair_flush(w->files, FILE_LOG);
  if (log != 0) take_back(w);
  note_handed(w);
  return file_pair_flush(w->files, FILE_JSON) != 0 || log != 0 ? -1 : 0;
}

static int flush_when_full(struct writer *w) {
  const int full = text_room(&w->files->file[FILE_LOG].text) < CAN_LINE || text_room(json(w)) < 4 * LINE_ROOM;
  return full ? flush_all(w) : 0;
}

void writer_give_up(struct writer *w, uint64_t abandoned) {
  w->events_not_written += abandoned;
  for (int i = 0; i <= w->sources; i++) {
    struct ring *r = ring_of(w, i);
    if (i < w->sources) w->events_not_written += w->source[i].count.events_abandoned;
    for (; ring_filled(r); ring_drop(r, 1)) {
      const struct item *item = ring_peek(r, 0);
      const int counted = ITEM_IS_COUNTED(item->kind);
      w->state[item->source].not_written += (uint64_t)counted;
      w->events_not_written += (uint64_t)!counted;
    }
  }
}

/* the log's next file, behind the lines that are in this one; that it cannot be begun is said once */
static void divide(struct writer *w) {
  const int known = w->files->refused, next = file_pair_next(w->files, clock_mono_ns());
  if (next == 0 || (next < 0 && known)) return;
  const char *slash = strrchr(w->files->part_path, '/');
  text_begin(json(w), "file");
  text_set_string(json(w), "name", slash ? slash + 1 : w->files->part_path);
  text_set_bool(json(w), "begun", next > 0);
  text_set(json(w), "errno", w->files->refused);
  text_set(json(w), "real_ns", clock_real_ns());
  text_end(json(w));
}

int writer_cycle(struct writer *w, int all) {
  if (file_pair_failure(w->files)) return -1;
  const int64_t until = settled_until(w);
  for (int i; (i = choose(w, until, all)) >= 0;) {
    put(w, ring_peek(ring_of(w, i), 0));
    ring_drop(ring_of(w, i), 1);
    if (flush_when_full(w) != 0) return -1;
  }
  for (int i = 0; i < w->sources; i++)
    if (w->state[i].error_count) put_errors(w, i);
  note_heads(w);
  if (flush_all(w) != 0) return -1;
  if (w->files->part_path && !all) divide(w);
  return 0;
}

/* ---- the disk ------------------------------------------------------------------------- */

int writer_sync(struct writer *w) {
  uint64_t handed[MAX_SOURCES];
  for (int i = 0; i < w->sources; i++) handed[i] = __atomic_load_n(&w->state[i].handed, __ATOMIC_ACQUIRE);
  if (file_pair_sync(w->files, FILE_LOG) != 0) return -1;
  for (int i = 0; i < w->sources; i++) __atomic_store_n(&w->state[i].synced, handed[i], __ATOMIC_RELEASE);
  return file_pair_sync(w->files, FILE_JSON);
}

void writer_tell_not_synced(struct writer *w) {
  for (int i = 0; i < w->sources; i++) {
    const struct written *s = &w->state[i];
    if (!source_is_can(&w->source[i]) || s->frames == s->synced) continue;
    begin(w, "drop", i);
    text_set_string(json(w), "where", "disk");
    text_set(json(w), "lost", (int64_t)(s->frames - s->synced));
    end_at(w, s->synced, s->last_ns);
  }
}

/* ---- the account ------------------------------------------------------------------------ */

struct account writer_account(const struct writer *w, int source) {
  const struct written *s = &w->state[source];
  const struct source_counts *c = &w->source[source].count;
  const int frames = source_is_can(&w->source[source]);
  return (struct account){.read = c->read,
                          .frames = c->frames,
                          .errors = c->errors,
                          .malformed = c->malformed,
                          .foreign = c->foreign,
                          .lost = {s->lost[0], s->lost[1]},
                          .written = frames ? s->frames : s->edges + s->pulses,
                          .synced = frames ? s->synced : s->edges + s->pulses,
                          .not_written = s->not_written + c->abandoned,
                          .perhaps_lost = s->perhaps_lost,
                          .not_known = s->not_known};
}

uint64_t writer_lost(const struct writer *w) {
  uint64_t lost = 0;
  for (int i = 0; i < w->sources; i++) {
    const struct account a = writer_account(w, i);
    lost += account_lost(&a);
  }
  return lost;
}

struct writer_stops writer_stops(const struct writer *w) {
  struct writer_stops sum = {0, 0, 0};
  for (int i = 0; i < w->sources; i++) {
    sum.all += w->state[i].stops.all;
    sum.partial += w->state[i].stops.partial;
    sum.failed += w->state[i].stops.failed;
  }
  return sum;
}

int writer_knows(const struct writer *w) {
  for (int i = 0; i < w->sources; i++)
    if (w->state[i].perhaps_lost || w->state[i].not_known) return 0;
  return 1;
}
