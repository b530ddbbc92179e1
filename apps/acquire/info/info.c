/* info.c: the two summaries for people, and as JSON. */
#define _GNU_SOURCE

#include "info.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/cli.h"
#include "common/json_file.h"
#include "events_summary.h"
#include "log_summary.h"
#include "talus/version.h"

static const char *report;

static const struct cli_option options[] = {
    {"report", 0, CLI_TEXT, &report, 0, "R.json", "the same as JSON"},
};

static const struct cli_program program = {
    .name = "talus-acquire info",
    .summary = "says what a record holds, its gaps, clocks and rates",
    .example = "talus-acquire info walk.log",
    .arguments = "REC.log",
    .min_arguments = 1,
    .max_arguments = 1,
    .option = options,
    .options = sizeof options / sizeof options[0],
};

static double seconds(int64_t ns) {
  return 1e-9 * (double)ns;
}

/* frames a second between a message's first and last one */
static double rate_of(const struct log_message *m) {
  const double span_s = seconds(m->last_ns - m->first_ns);
  return span_s > 0.0 ? (double)(m->frames - 1) / span_s : 0.0;
}

/* ---- for people ------------------------------------------------------------------------ */

static void print_log(const struct log_summary *s) {
  printf("%" PRIu64 " frames in %.3f s, from %.6f to %.6f; %" PRIu64 " remote, %" PRIu64 " error frames\n",
         s->frames, seconds(s->last_ns - s->first_ns), seconds(s->first_ns), seconds(s->last_ns), s->remote,
         s->errors);
  if (s->no_frames)
    printf("%" PRIu64 " lines are no frames, the first is line %" PRIu64 "\n", s->no_frames,
           s->first_no_frame);
  if (s->cut) printf("the last line is cut off\n");
  if (s->files > 1) printf("in %d files\n", s->files);
  if (s->uncounted) printf("%" PRIu64 " frames of further messages\n", s->uncounted);
  if (s->messages)
    printf("%-15s %10s %10s %10s  longest silence\n", "interface", "id", "frames", "per second");
  for (int i = 0; i < s->messages; i++) {
    const struct log_message *m = &s->message[i];
    char name[2 * LOG_NAME];
    app_printable(name, sizeof name, m->name, strlen(m->name));
    printf("%-15s %10.*" PRIX32 " %10" PRIu64 " %10.1f  %.6f s at %.6f", name, m->extended ? 8 : 3, m->id,
           m->frames, rate_of(m), seconds(m->longest_ns), seconds(m->longest_at_ns));
    printf(m->backwards ? ", %" PRIu64 " stamps go back\n" : "\n", m->backwards);
  }
}

/* as the export says it: how long after the first reading */
static void print_steps(const struct events_summary *e) {
  enum { SHOWN = 5 };
  for (uint64_t i = 0; i < e->steps && i < SHOWN; i++) {
    const struct clock_step *s = &e->step[i];
    printf("the clock was set %s by %.6f s between %.3f s and %.3f s\n", s->size_ns < 0 ? "back" : "forward",
           fabs(seconds(s->size_ns)), seconds(s->before_ns) - seconds(e->first.mono_ns),
           seconds(s->after_ns) - seconds(e->first.mono_ns));
  }
}

static void print_events(const struct events_summary *e) {
  if (!e->there) {
    printf("no events file beside it: what was lost, and the clocks, are not known\n");
    return;
  }
  printf("lost, as the recorder says: %" PRIu64 " at %" PRIu64 " places\n", e->lost, e->drops);
  if (e->perhaps_lost || e->not_known)
    printf("perhaps %" PRIu64 " more, and what was on its way in %" PRIu64 " interfaces that vanished\n",
           e->perhaps_lost, e->not_known);
  printf("clocks: read %" PRIu64 " times in %.3f s, within %.1f us", e->clocks,
         seconds(e->last.mono_ns) - seconds(e->first.mono_ns), 1e-3 * (double)e->widest_ns);
  if (e->steps) printf("; set %" PRIu64 " times, at most by %.6f s", e->steps, seconds(e->largest_step_ns));
  printf("\n");
  print_steps(e);
  printf("%" PRIu64 " changes of interfaces, %" PRIu64 " edges, %" PRIu64 " pulses, %" PRIu64
         " emergency stops (%" PRIu64 " not sent, %" PRIu64 " only in part)\n",
         e->links, e->edges, e->pulses, e->stops, e->stops_failed, e->stops_partial);
  printf(e->reason[0] ? "ended by %s\n" : "%sno end: the recorder was killed\n", e->reason);
}

/* ---- for machines ------------------------------------------------------------------------ */

static void set_whole(json_t *object, const char *key, uint64_t value) {
  json_object_set_new(object, key, json_integer((json_int_t)value));
}

static json_t *messages_of(const struct log_summary *s) {
  json_t *list = json_array();
  for (int i = 0; i < s->messages; i++) {
    const struct log_message *m = &s->message[i];
    json_t *one = json_object();
    json_set_text(one, "interface", m->name);
    set_whole(one, "identifier", m->id);
    json_object_set_new(one, "extended", json_boolean(m->extended));
    set_whole(one, "frames", m->frames);
    json_set_number(one, "rate_hz", rate_of(m));
    set_whole(one, "stamps_backwards", m->backwards);
    set_whole(one, "longest_silence_ns", (uint64_t)m->longest_ns);
    set_whole(one, "longest_silence_at_ns", (uint64_t)m->longest_at_ns);
    json_array_append_new(list, one);
  }
  return list;
}

static json_t *steps_of(const struct events_summary *e) {
  json_t *list = json_array();
  for (uint64_t i = 0; i < e->steps && i < EVENTS_STEPS; i++) {
    json_t *one = json_object();
    json_object_set_new(one, "before_mono_ns", json_integer(e->step[i].before_ns));
    json_object_set_new(one, "after_mono_ns", json_integer(e->step[i].after_ns));
    json_set_number(one, "size_s", seconds(e->step[i].size_ns));
    json_array_append_new(list, one);
  }
  return list;
}

static json_t *events_of(const struct events_summary *e) {
  if (!e->there) return json_null();
  json_t *object = json_object();
  set_whole(object, "lost", e->lost);
  set_whole(object, "perhaps_lost", e->perhaps_lost);
  set_whole(object, "not_known", e->not_known);
  set_whole(object, "drops", e->drops);
  set_whole(object, "links", e->links);
  set_whole(object, "edges", e->edges);
  set_whole(object, "pulses", e->pulses);
  set_whole(object, "stops", e->stops);
  set_whole(object, "stops_partial", e->stops_partial);
  set_whole(object, "stops_failed", e->stops_failed);
  set_whole(object, "clocks", e->clocks);
  set_whole(object, "clock_steps", e->steps);
  json_set_number(object, "largest_step_s", seconds(e->largest_step_ns));
  json_object_set_new(object, "steps", steps_of(e));
  json_object_set_new(object, "ended_by", e->reason[0] ? json_text(e->reason) : json_null());
  return object;
}

static int write_report(const struct log_summary *s, const struct events_summary *e,
                        struct app_error *error) {
  json_t *root = json_object();
  json_set_text(root, "schema", "talus-acquire-info/1");
  json_set_text(root, "version", tl_version());
  set_whole(root, "frames", s->frames);
  set_whole(root, "error_frames", s->errors);
  set_whole(root, "remote_frames", s->remote);
  set_whole(root, "no_frames", s->no_frames);
  json_object_set_new(root, "cut", json_boolean(s->cut));
  json_object_set_new(root, "files", json_integer(s->files));
  set_whole(root, "first_ns", (uint64_t)s->first_ns);
  set_whole(root, "last_ns", (uint64_t)s->last_ns);
  json_object_set_new(root, "messages", messages_of(s));
  json_object_set_new(root, "events", events_of(e));
  const int result = json_file_write(report, root, error);
  json_decref(root);
  return result;
}

/* ---- all of it ------------------------------------------------------------------------- */

static int look_at(const char *path, struct app_error *error) {
  struct events_summary events;
  struct log_summary *log = log_summary_read(path, error);
  if (!log) return -1;
  int result = 0;
  if (!log->frames && log->no_frames)
    result = app_fail(error, APP_BAD_INPUT, "%s:%" PRIu64 ": no line of candump's log format", path,
                      log->first_no_frame ? log->first_no_frame : 1);
  events_summary_read(path, &events);
  if (result == 0 && report) result = write_report(log, &events, error);
  if (result == 0) {
    print_log(log);
    print_events(&events);
  }
  free(log);
  return result;
}

int info_main(int argc, char **argv) {
  struct app_error error;
  int first;
  switch (cli_parse(&program, argc, argv, &first)) {
  case CLI_RUN: return look_at(argv[first], &error) == 0 ? APP_OK : app_exit(&error);
  case CLI_DONE: return APP_OK;
  case CLI_USAGE: break;
  }
  return APP_BAD_INPUT;
}
