/* watch.h: what the main thread does while others record: clocks, interfaces, the emergency stop's path, the live line. */
#ifndef WATCH_H
#define WATCH_H

#include "acquire/play/stop_line.h"
#include "writer.h"

/* An interface's counters, up to which what it lost has been told. */
struct link_told {
  int index;
  uint64_t counter[LINK_COUNTERS];
};

struct watch {
  struct ring events; /* clocks, links, statistics: to the writer */
  const struct source *source;
  int sources;
  struct stop_line *stop; /* NULL none */
  int netlink, link_events;
  int clock_set;                       /* a timer that is readable when somebody has set the clock; -1 none */
  int64_t start_ns, end_ns;            /* monotonic; end 0: none */
  struct link_state link[MAX_SOURCES]; /* as last looked at */
  struct link_told told[MAX_SOURCES];
  uint64_t live_seen[MAX_SOURCES]; /* by the last live line */
  uint64_t stops_told[MAX_SOURCES];
  int path_failure;   /* of the stop's path, as last told; -1 not yet */
  uint64_t abandoned; /* events, not put into the ring: the writer was dead */
};

/* 0, or -1 with the reason. */
int watch_open(struct watch *w, const struct source *source, int sources, struct stop_line *stop,
               struct app_error *error);
void watch_close(struct watch *w);

/* Into the ring of events. */
void watch_clock(struct watch *w);
/* The same at once when the clock was set: `clock_set` is readable then. */
void watch_clock_set(struct watch *w);
/* Interfaces up and down, their counters and bus states; the stop's path. `report` writes statistics in any case. */
void watch_links(struct watch *w, int report);
/* The same when the kernel says that an interface has changed. */
void watch_link_events(struct watch *w);
/* Says on standard error how each emergency stop went that has not been told yet. */
void watch_stops(struct watch *w);
/* One line on standard error, over the last one. */
void watch_live_line(struct watch *w);
/* What is printed next begins a line of its own. */
void watch_live_end(void);

#endif
