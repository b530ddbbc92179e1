/* side_file.c: how a recording began, how it ended. */
#define _GNU_SOURCE

#include "side_file.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/utsname.h>

#include "clocks.h"
#include "talus/version.h"

static struct text *json(struct session *s) {
  return &s->files.file[FILE_JSON].text;
}

static int is_can(const struct source *source) {
  return source->spec.kind == SOURCE_CAN || source->spec.kind == SOURCE_FD;
}

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

void side_file_header(struct session *s) {
  struct text *t = json(s);
  struct utsname kernel;
  const struct clock_triple now = clock_read_triple();
  memset(&kernel, 0, sizeof kernel);
  uname(&kernel);
  text_begin(t, "header");
  text_set_string(t, "schema", "talus-acquire/1");
  text_set_string(t, "version", tl_version());
  text_set_string(t, "log", last_part(s->files.file[FILE_LOG].path));
  text_set(t, "real_ns", now.real_ns);
  text_set(t, "mono_ns", now.mono_ns);
  text_set(t, "raw_ns", now.raw_ns);
  text_set_string(t, "kernel", kernel.release);
  text_key(t, "sources");
  text_string(t, "[");
  for (int i = 0; i < s->sources; i++) {
    const struct source *source = &s->source[i];
    text_string(t, i ? ",{\"index\":" : "{\"index\":");
    text_whole(t, i);
    text_set_string(t, "name", source->spec.name);
    text_set_string(t, "kind", source_kind_name(source->spec.kind));
    if (is_can(source))
      put_can(t, source);
    else
      put_gpio(t, source, s->settings->source.gpio->name);
    text_string(t, "}");
  }
  text_string(t, "]");
  put_realtime(t, &s->realtime);
  text_end(t);
}

/* ---- end -------------------------------------------------------------------------- */

static uint64_t lost_of(const struct session *s, int i) {
  const struct written *w = &s->writer.state[i];
  return w->lost[0] + w->lost[1] + s->source[i].abandoned + s->source[i].malformed + w->stops_failed;
}

uint64_t side_file_lost(const struct session *s) {
  uint64_t lost = 0;
  for (int i = 0; i < s->sources; i++) lost += lost_of(s, i);
  return lost;
}

static void put_source_end(struct text *t, const struct session *s, int i) {
  const struct source *source = &s->source[i];
  const struct written *w = &s->writer.state[i];
  text_string(t, i ? ",{\"index\":" : "{\"index\":");
  text_whole(t, i);
  text_set_string(t, "name", source->spec.name);
  text_set(t, is_can(source) ? "frames" : "edges", (int64_t)(is_can(source) ? w->frames : w->edges));
  if (is_can(source)) {
    text_set(t, "lost_socket", (int64_t)w->lost[ITEM_IN_SOCKET]);
    text_set(t, "lost_interface", (int64_t)w->lost[ITEM_IN_INTERFACE]);
    text_set(t, "errors", (int64_t)w->errors);
    text_set(t, "stamps_backwards", (int64_t)w->backwards);
    text_set_string(t, "state", bus_state_name(w->bus.state));
  } else {
    text_set(t, "lost", (int64_t)w->lost[0]);
    text_set(t, "stops", (int64_t)w->stops);
    text_set(t, "stops_failed", (int64_t)w->stops_failed);
  }
  if (source->spec.kind == SOURCE_FD) text_set(t, "malformed", (int64_t)source->malformed);
  text_set(t, "not_written", (int64_t)source->abandoned);
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

void side_file_end(struct session *s) {
  struct text *t = json(s);
  text_begin(t, "end");
  text_set_string(t, "reason", session_reason_text(s));
  text_set(t, "real_ns", clock_real_ns());
  text_set(t, "mono_ns", clock_mono_ns());
  text_set(t, "lost", (int64_t)side_file_lost(s));
  text_key(t, "sources");
  text_string(t, "[");
  for (int i = 0; i < s->sources; i++) put_source_end(t, s, i);
  text_string(t, "]");
  put_loop(t, &s->loop);
  text_end(t);
}

/* ---- words ------------------------------------------------------------------------ */

static void print_source(const struct session *s, int i, double seconds) {
  const struct source *source = &s->source[i];
  const struct written *w = &s->writer.state[i];
  if (is_can(source)) {
    fprintf(stderr,
            "  %-15s %10" PRIu64 " frames %9.1f/s  lost %" PRIu64 " in the socket, %" PRIu64 " below  ",
            source->spec.name, w->frames, (double)w->frames / seconds, w->lost[ITEM_IN_SOCKET],
            w->lost[ITEM_IN_INTERFACE]);
    fprintf(stderr, "errors %" PRIu64 "  bus %s  %s stamps", w->errors, bus_state_name(w->bus.state),
            source->hardware_stamps ? "hardware" : "software");
  } else {
    fprintf(stderr, "  %-15s %10" PRIu64 " edges            lost %" PRIu64, source->spec.name, w->edges,
            w->lost[0]);
    if (source->spec.kind == SOURCE_ESTOP)
      fprintf(stderr, "  stop sent %" PRIu64 " times, failed %" PRIu64, w->stops, w->stops_failed);
  }
  if (source->malformed) fprintf(stderr, "  no frames %" PRIu64, source->malformed);
  if (source->abandoned) fprintf(stderr, "  NOT WRITTEN %" PRIu64, source->abandoned);
  fputc('\n', stderr);
}

void side_file_summary(const struct session *s) {
  const double seconds = 1e-9 * (double)(clock_mono_ns() - s->clock.start_ns);
  const uint64_t lost = side_file_lost(s);
  fprintf(stderr, "%s: %.1f s, ended by %s, ", s->files.file[FILE_LOG].path, seconds, session_reason_text(s));
  fprintf(stderr, lost ? "LOST %" PRIu64 "\n" : "nothing lost\n", lost);
  for (int i = 0; i < s->sources; i++) print_source(s, i, seconds);
  if (s->settings->play) player_print(&s->player);
  fprintf(stderr, "  after start: page faults %" PRId64 " minor, %" PRId64 " major", s->loop.minor_faults,
          s->loop.major_faults);
  if (s->loop.allocations >= 0)
    fprintf(stderr, "; allocations %" PRId64 "\n", s->loop.allocations);
  else
    fprintf(stderr, "; allocations are not counted in this build\n");
}
