/* events_summary.c: JSON lines, one at a time. */
#include "events_summary.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clock/clock_step.h"

enum { LINE = 1 << 20, PATH = 4096 };

static int64_t whole(const json_t *event, const char *key) {
  return json_integer_value(json_object_get(event, key));
}

static double size(int64_t ns) {
  return ns < 0 ? -(double)ns : (double)ns;
}

/* differences without sign first: a foreign file may hold any number */
static int64_t less(int64_t a, int64_t b) {
  return (int64_t)((uint64_t)a - (uint64_t)b);
}

static void look_for_step(struct events_summary *s, const struct clock_reading *a,
                          const struct clock_reading *b) {
  const int64_t passed = less(b->mono_ns, a->mono_ns), change = less(less(b->real_ns, a->real_ns), passed);
  if (size(change) <= clock_drift_most_ns((double)passed, (double)a->width_ns + (double)b->width_ns)) return;
  if (s->steps < EVENTS_STEPS) s->step[s->steps] = (struct clock_step){a->mono_ns, b->mono_ns, change};
  s->steps++;
  if (size(change) > size(s->largest_step_ns)) s->largest_step_ns = change;
}

/* a reading that is no later than the one before it says nothing of a step */
static void take_clock(struct events_summary *s, const json_t *event) {
  const struct clock_reading now = {whole(event, "mono_ns"), whole(event, "real_ns"),
                                    whole(event, "width_ns")};
  if (s->clocks == 0) s->first = s->latest = now;
  if (s->clocks && now.mono_ns > s->last.mono_ns) {
    look_for_step(s, &s->latest, &now);
    s->latest = now;
  }
  if (now.width_ns > s->widest_ns) s->widest_ns = now.width_ns;
  s->last = now;
  s->clocks++;
}

static void take_vanished(struct events_summary *s, const json_t *event) {
  s->lost += (uint64_t)whole(event, "lost");
  s->drops += whole(event, "lost") != 0;
  s->perhaps_lost += (uint64_t)whole(event, "perhaps_lost");
  s->not_known += (uint64_t)json_is_false(json_object_get(event, "known"));
}

static void take_stop(struct events_summary *s, const json_t *event) {
  const int sent = json_is_true(json_object_get(event, "sent"));
  s->stops++;
  s->stops_partial += sent && whole(event, "errno") != 0;
  s->stops_failed += !sent;
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
  if (strcmp(type, "stop") == 0) take_stop(s, event);
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
