/* events_file.h: first and last line of the events file (JSON lines), and the summary for people. */
#ifndef EVENTS_FILE_H
#define EVENTS_FILE_H

#include "acquire/host/realtime.h"
#include "writer.h"

/* How a recording began. */
struct events_begin {
  const char *log; /* path of the log */
  const struct source *source;
  int sources;
  const char *gpio_backend;
  const struct realtime *realtime;
};
void events_file_begin(struct text *json, const struct events_begin *facts);

/* How it ended; all threads have. */
struct events_end {
  const char *reason;
  const struct writer *writer;
  const struct loop_count *loop;
};
void events_file_end(struct text *json, const struct events_end *facts);
/* On standard error. */
void events_file_summary(const struct events_end *facts, const char *log, double seconds);

#endif
