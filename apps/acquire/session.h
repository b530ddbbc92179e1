/* session.h: one recording: sources, writer, and the thread that watches over them. */
#ifndef SESSION_H
#define SESSION_H

#include <pthread.h>

#include "player.h"
#include "realtime.h"
#include "writer.h"

struct session_settings {
  const char *out;
  int overwrite;
  double duration_s; /* 0: until it is stopped */
  int realtime;      /* ask for priority and locked memory */
  int quiet;         /* no live line, no summary */
  struct source_settings source;
  const char *stop;                    /* "can0" or "can0:001#0011": the stop frame; NULL none */
  const char *play, *play_on, *limits; /* trajectory, interface, limits; NULL none */
  double play_latest_s;                /* a set-point later than this ends the playing */
};

enum session_reason {
  REASON_NONE,
  REASON_DURATION,
  REASON_SIGNAL,
  REASON_PLAYED, /* the trajectory is at its end */
  REASON_CLOSED, /* every inherited socket is closed */
  REASON_DISK
};

struct session {
  const struct session_settings *settings;
  struct source source[MAX_SOURCES];
  int sources;
  struct ring events; /* clocks, links, statistics: from the main thread */
  struct file_pair files;
  struct writer writer;
  struct realtime realtime;
  struct stop_line stop_line;
  int netlink, link_events, signals;

  struct player player;
  pthread_t reader_thread[MAX_SOURCES], writer_thread, sync_thread, player_thread;
  pthread_barrier_t ready, warm;
  int stop_reading, stop_writing;
  enum session_reason reason;

  struct clock_state {
    int64_t start_ns, end_ns; /* monotonic */
    int64_t next_second_ns;
    int64_t played_ns; /* when the player was seen to have ended, 0 */
    int second;
  } clock;
  struct link_state link[MAX_SOURCES]; /* as last looked at */
  uint64_t live_seen[MAX_SOURCES];     /* by the last live line */
  struct loop_count loop;              /* at the start; then what was added */
};

/* Opens all; nothing of it stays on failure, no file either. */
int session_open(struct session *s, const struct session_settings *settings, const struct source_spec *spec,
                 int sources, struct app_error *error);
/* Records until the duration is over, a signal comes, or the disk refuses. 0, or -1 with status 1: something
 * was lost or could not be written. */
int session_run(struct session *s, struct app_error *error);
void session_close(struct session *s);

const char *session_reason_text(const struct session *s);

#endif
