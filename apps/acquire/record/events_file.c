/* events_file.c: how a recording began, how it ended. */
#define _GNU_SOURCE

#include "events_file.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/utsname.h>

#include "acquire/host/clocks.h"
#include "talus/version.h"

/* ---- header ----------------------------------------------------------------------- */

static void put_can(struct text *t, const struct source *source) {
  const struct link_state *link = &source->link;
  text_set_string(t, "stamps", source->hardware_stamps ? "hardware" : "software");
  text_set_bool(t, "fd", source->takes_fd_frames);
  text_set_bool(t, "up", link->up);
  text_set_string(t, "driver", link->driver);
  text_set_string(t, "state", bus_state_name(link->bus.state));
  text_set(t, "bitrate", link->bitrate);
  text_set(t, "data_bitrate", link->data_bitrate);
  text_set(t, "restart_ms", link->restart_ms);
  text_set(t, "receive_buffer", source->receive_buffer);
}

static void put_gpio(struct text *t, const struct source *source, const char *backend) {
  static const char *const edges[] = {"none", "rising", "falling", "both"};
  text_set_string(t, "stamps", "monotonic");
  text_set_string(t, "chip", source->spec.line.chip);
  text_set_string(t, "line", source->spec.line.name);
  text_set_string(t, "edges", edges[source->spec.line.edges]);
  text_set_string(t, "backend", backend);
  if (source->pressed >= 0) text_set_bool(t, "pressed", source->pressed);
}

static void put_realtime(struct text *t, const struct realtime *rt) {
  text_key(t, "realtime");
  text_string(t, "{\"wanted\":");
  text_string(t, rt->wanted ? "true" : "false");
  text_set_bool(t, "locked", rt->wanted && !rt->lock_refused);
  text_set_bool(t, "fifo", rt->wanted && !rt->fifo_refused);
  text_set_bool(t, "no_deep_sleep", rt->wanted && !rt->latency_refused);
  text_string(t, "}");
}

static const char *last_part(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash ? slash + 1 : path;
}

void events_file_begin(struct text *json, const struct events_begin *facts) {
  struct text *t = json;
  struct utsname kernel;
  const struct clock_triple now = clock_read_triple();
  memset(&kernel, 0, sizeof kernel);
  uname(&kernel);
  text_begin(t, "header");
  text_set_string(t, "schema", "talus-acquire/1");
  text_set_string(t, "version", tl_version());
  text_set_string(t, "log", last_part(facts->log));
  text_set(t, "real_ns", now.real_ns);
  text_set(t, "mono_ns", now.mono_ns);
  text_set(t, "raw_ns", now.raw_ns);
  text_set_string(t, "kernel", kernel.release);
  text_key(t, "sources");
  text_string(t, "[");
  for (int i = 0; i < facts->sources; i++) {
    const struct source *source = &facts->source[i];
    text_string(t, i ? ",{\"index\":" : "{\"index\":");
    text_whole(t, i);
    text_set_string(t, "name", source->spec.name);
    text_set_string(t, "kind", source_kind_name(source->spec.kind));
    if (source_is_can(source))
      put_can(t, source);
    else
      put_gpio(t, source, facts->gpio_backend);
    text_string(t, "}");
  }
  text_string(t, "]");
  put_realtime(t, facts->realtime);
  text_end(t);
}

/* ---- end -------------------------------------------------------------------------- */

static void put_account(struct text *t, const struct account *a) {
  text_set(t, "read", (int64_t)a->read);
  text_set(t, "not_written", (int64_t)a->not_written);
  text_set(t, "synced", (int64_t)a->synced);
  text_set(t, "not_synced", (int64_t)(a->written - a->synced));
  text_set(t, "unexplained", (int64_t)account_difference(a));
}

static void put_source_end(struct text *t, const struct writer *writer, int i) {
  const struct source *source = &writer->source[i];
  const struct written *w = &writer->state[i];
  const struct account a = writer_account(writer, i);
  text_string(t, i ? ",{\"index\":" : "{\"index\":");
  text_whole(t, i);
  text_set_string(t, "name", source->spec.name);
  if (source_is_can(source)) {
    text_set(t, "frames", (int64_t)w->frames);
    text_set(t, "lost_socket", (int64_t)w->lost[ITEM_IN_SOCKET]);
    text_set(t, "lost_interface", (int64_t)w->lost[ITEM_IN_INTERFACE]);
    text_set(t, "perhaps_lost", (int64_t)w->perhaps_lost);
    text_set(t, "not_known", (int64_t)w->not_known);
    text_set(t, "errors", (int64_t)w->errors);
    text_set(t, "stamps_backwards", (int64_t)w->backwards);
    text_set(t, "stamps_estimated", (int64_t)w->estimated);
    text_set_string(t, "state", bus_state_name(w->bus.state));
  } else {
    text_set(t, "edges", (int64_t)(w->edges + w->pulses));
    text_set(t, "lost", (int64_t)w->lost[0]);
    text_set(t, "stops", (int64_t)w->stops.all);
    text_set(t, "stops_partial", (int64_t)w->stops.partial);
    text_set(t, "stops_failed", (int64_t)w->stops.failed);
  }
  if (source->spec.kind == SOURCE_FD) text_set(t, "malformed", (int64_t)a.malformed);
  if (source->spec.kind == SOURCE_CAN) text_set(t, "other_interfaces", (int64_t)a.foreign);
  put_account(t, &a);
  text_set(t, "ring_most", source->ring.most);
  text_string(t, "}");
}

static void put_loop(struct text *t, const struct loop_count *loop) {
  text_key(t, "loop");
  text_string(t, "{\"page_faults_minor\":");
  text_whole(t, loop->minor_faults);
  text_set(t, "page_faults_major", loop->major_faults);
  if (loop->allocations >= 0) {
    text_set(t, "allocations", loop->allocations);
  } else {
    text_key(t, "allocations");
    text_string(t, "null");
  }
  text_string(t, "}");
}

void events_file_end(struct text *json, const struct events_end *facts) {
  struct text *t = json;
  const struct writer *writer = facts->writer;
  text_begin(t, "end");
  text_set_string(t, "reason", facts->reason);
  text_set(t, "real_ns", clock_real_ns());
  text_set(t, "mono_ns", clock_mono_ns());
  text_set(t, "lost", (int64_t)writer_lost(writer));
  text_set(t, "events_not_written", (int64_t)writer->events_not_written);
  text_set(t, "out_of_order", (int64_t)writer->out_of_order);
  text_key(t, "sources");
  text_string(t, "[");
  for (int i = 0; i < writer->sources; i++) put_source_end(t, writer, i);
  text_string(t, "]");
  put_loop(t, facts->loop);
  text_end(t);
}

/* ---- words ------------------------------------------------------------------------ */

static void print_frames(const struct source *source, const struct written *w, double seconds) {
  fprintf(stderr, "  %-15s %10" PRIu64 " frames %9.1f/s  lost %" PRIu64 " in the socket, %" PRIu64 " below  ",
          source->spec.name, w->frames, (double)w->frames / seconds, w->lost[ITEM_IN_SOCKET],
          w->lost[ITEM_IN_INTERFACE]);
  fprintf(stderr, "errors %" PRIu64 "  bus %s  %s stamps", w->errors, bus_state_name(w->bus.state),
          source->hardware_stamps ? "hardware" : "software");
}

static void print_edges(const struct source *source, const struct written *w) {
  fprintf(stderr, "  %-15s %10" PRIu64 " edges            lost %" PRIu64, source->spec.name,
          w->edges + w->pulses, w->lost[0]);
  if (source->spec.kind == SOURCE_ESTOP)
    fprintf(stderr, "  emergency stops %" PRIu64 ", in part %" PRIu64 ", not sent %" PRIu64, w->stops.all,
            w->stops.partial, w->stops.failed);
}

static void print_source(const struct writer *writer, int i, double seconds) {
  const struct source *source = &writer->source[i];
  const struct account a = writer_account(writer, i);
  if (source_is_can(source))
    print_frames(source, &writer->state[i], seconds);
  else
    print_edges(source, &writer->state[i]);
  if (a.malformed) fprintf(stderr, "  no frames %" PRIu64, a.malformed);
  if (a.perhaps_lost) fprintf(stderr, "  PERHAPS LOST %" PRIu64 " more", a.perhaps_lost);
  if (a.not_known)
    fprintf(stderr, "  VANISHED %" PRIu64 " times, what was on its way is in no count", a.not_known);
  if (a.not_written) fprintf(stderr, "  NOT WRITTEN %" PRIu64, a.not_written);
  if (a.written != a.synced) fprintf(stderr, "  MAYBE NOT ON THE DISK %" PRIu64, a.written - a.synced);
  if (account_difference(&a)) fprintf(stderr, "  UNEXPLAINED %" PRIu64, account_difference(&a));
  fputc('\n', stderr);
}

static void print_lost(uint64_t lost, int is_known) {
  if (lost) fprintf(stderr, "LOST %" PRIu64 "%s\n", lost, is_known ? "" : ", and perhaps more");
  if (!lost) fprintf(stderr, is_known ? "nothing lost\n" : "WHETHER ANYTHING IS LOST IS NOT KNOWN\n");
}

void events_file_summary(const struct events_end *facts, const char *log, double seconds) {
  const uint64_t lost = writer_lost(facts->writer);
  fprintf(stderr, "%s: %.1f s, ended by %s, ", log, seconds, facts->reason);
  print_lost(lost, writer_knows(facts->writer));
  for (int i = 0; i < facts->writer->sources; i++) print_source(facts->writer, i, seconds);
  if (facts->writer->events_not_written)
    fprintf(stderr, "  EVENTS NOT WRITTEN %" PRIu64 "\n", facts->writer->events_not_written);
  fprintf(stderr, "  after start: page faults %" PRId64 " minor, %" PRId64 " major",
          facts->loop->minor_faults, facts->loop->major_faults);
  if (facts->loop->allocations >= 0)
    fprintf(stderr, "; allocations %" PRId64 "\n", facts->loop->allocations);
  else
    fprintf(stderr, "; allocations are not counted in this build\n");
}
