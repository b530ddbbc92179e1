/* events_summary.c: JSON lines, one at a time. */
#include "events_summary.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINE = 1 << 20, PATH = 4096, READ_NS = 20000 };
static const double MOST_DRIFT = 600e-6; /* what changes faster is no drift: the clock was set */

static int64_t whole(const json_t *event, const char *key) {
  return json_integer_value(json_object_get(event, key));
}

static double size(int64_t ns) {
  return ns < 0 ? -(double)ns : (double)ns;
}

static int is_step(int64_t drift_ns, int64_t passed_ns, int64_t width_ns) {
  return size(drift_ns) > MOST_DRIFT * size(passed_ns) + size(width_ns) + READ_NS;
}

/* differences without sign first: a foreign file may hold any number */
static int64_t less(int64_t a, int64_t b) {
  return (int64_t)((uint64_t)a - (uint64_t)b);
}

static void take_clock(struct events_summary *s, const json_t *event) {
  const int64_t mono = whole(event, "mono_ns"), real = whole(event, "real_ns"),
                width = whole(event, "width_ns");
  if (s->clocks++ == 0) {
    s->first_mono_ns = mono;
    s->first_real_ns = real;
  } else {
    const int64_t passed = less(mono, s->last_mono_ns), drift = less(less(real, s->last_real_ns), passed);
    s->steps += (uint64_t)is_step(drift, passed, width);
    if (is_step(drift, passed, width) && size(drift) > size(s->largest_step_ns)) s->largest_step_ns = drift;
  }
  if (width > s->widest_ns) s->widest_ns = width;
  s->last_mono_ns = mono;
  s->last_real_ns = real;
}

static void take_vanished(struct events_summary *s, const json_t *event) {
  s->lost += (uint64_t)whole(event, "lost");
  s->drops += whole(event, "lost") != 0;
  s->perhaps_lost += (uint64_t)whole(event, "perhaps_lost");
  s->not_known += (uint64_t)json_is_false(json_object_get(event, "known"));
}

static void take(struct events_summary *s, const json_t *event) {
  const char *type = json_string_value(json_object_get(event, "type"));
  if (!type) type = "";
  if (strcmp(type, "clock") == 0) take_clock(s, event);
  if (strcmp(type, "vanished") == 0) take_vanished(s, event);
  s->drops += strcmp(type, "drop") == 0;
  if (strcmp(type, "drop") == 0 || strcmp(type, "edges_lost") == 0) s->lost += (uint64_t)whole(event, "lost");
  s->links += strcmp(type, "link") == 0;
  s->edges += strcmp(type, "edge") == 0;
  s->pulses += strcmp(type, "pulse") == 0;
  s->stops += strcmp(type, "stop") == 0;
  if (strcmp(type, "end") != 0) return;
  const char *reason = json_string_value(json_object_get(event, "reason"));
  snprintf(s->reason, sizeof s->reason, "%s", reason ? reason : "not said");
}

/* REC.jsonl beside REC.log and REC.log.gz */
static int path_of(const char *log, char out[PATH]) {
  size_t n = strlen(log);
  if (n > 3 && strcmp(log + n - 3, ".gz") == 0) n -= 3;
  if (n > 4 && strncmp(log + n - 4, ".log", 4) == 0) n -= 4;
  return snprintf(out, PATH, "%.*s.jsonl", (int)n, log) < PATH ? 0 : -1;
}

void events_summary_read(const char *log, struct events_summary *summary) {
  char path[PATH];
  memset(summary, 0, sizeof *summary);
  FILE *file = path_of(log, path) == 0 ? fopen(path, "re") : NULL;
  char *line = malloc(LINE);
  summary->there = file != NULL;
  while (file && line && fgets(line, LINE, file)) {
    json_t *event = json_loads(line, 0, NULL);
    summary->lines++;
    summary->bad_lines += event == NULL;
    take(summary, event);
    json_decref(event);
  }
  free(line);
  if (file) fclose(file);
}
