/* events_summary.h: what a record's events file says, in figures. */
#ifndef EVENTS_SUMMARY_H
#define EVENTS_SUMMARY_H

#include <stdint.h>

enum { EVENTS_REASON = 32, EVENTS_STEPS = 64 };

struct clock_reading {
  int64_t mono_ns, real_ns, width_ns;
};

struct clock_step {
  int64_t before_ns, after_ns; /* the readings on either side, on the monotonic clock */
  int64_t size_ns;             /* of realtime; negative: back */
};

struct events_summary {
  int there;                                   /* is there such a file? */
  uint64_t lines, bad_lines;                   /* those that are no JSON */
  uint64_t lost;                               /* frames and edges, as drops tell */
  uint64_t perhaps_lost, not_known;            /* more at most; interfaces that vanished without a count */
  uint64_t drops, links, edges, pulses, stops; /* events */
  uint64_t stops_partial, stops_failed;        /* of which some frames did not go out; none */
  uint64_t clocks, steps;                      /* readings of the clocks; times that one was set */
  struct clock_step step[EVENTS_STEPS];        /* the first ones */
  int64_t largest_step_ns;                     /* of realtime */
  struct clock_reading first, last;            /* readings */
  struct clock_reading latest;                 /* the last one that is later than the one before it */
  int64_t widest_ns;                           /* a reading took so long */
  char reason[EVENTS_REASON];                  /* of the end; empty: there is none, the recorder was killed */
};

/* Of the events file beside a log; all zero when there is none. */
void events_summary_read(const char *log, struct events_summary *summary);

#endif
