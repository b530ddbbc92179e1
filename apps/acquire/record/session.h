/* session.h: one recording: sources, writer, and the thread that watches over them. */
#ifndef SESSION_H
#define SESSION_H

#include <pthread.h>

#include "acquire/host/realtime.h"
#include "acquire/play/player.h"
#include "acquire/play/stop_line.h"
#include "compressor.h"
#include "watch.h"

struct session_settings {
  const char *out;
  int overwrite;
  struct series_limit divide; /* when the log's next file begins */
  int compress;               /* the files that are full */
  double duration_s;          /* 0: until it is stopped */
  int realtime;               /* ask for priority and locked memory */
  int quiet;                  /* no live line, no summary */
  struct source_settings source;
  const char *stop;                    /* "can0" or "can0:001#0011": the stop frame; NULL none */
  const char *play, *play_on, *limits; /* trajectory, interface, limits; NULL none */
  double play_latest_s;                /* a set-point later than this ends the playing */
  const struct player_feed *feed;      /* who makes the set-points; NULL: the trajectory */
};

enum session_reason {
  REASON_NONE,
  REASON_DURATION,
  REASON_SIGNAL,
  REASON_PLAYED, /* the trajectory is at its end */
  REASON_CLOSED, /* every inherited socket is closed */
  REASON_SOURCE, /* a source cannot be read any longer */
  REASON_DISK
};

struct session {
  const struct session_settings *settings;
  struct source source[MAX_SOURCES];
  int sources;
  struct file_pair files;
  struct compressor compressor;
  struct writer writer;
  struct watch watch;
  struct realtime realtime;
  struct stop_line stop_line;
  struct player player;
  int signals;

  pthread_t reader_thread[MAX_SOURCES], writer_thread, sync_thread, player_thread, compress_thread;
  pthread_barrier_t warm;
  int stop_reading, stop_writing;
  enum session_reason reason;
  int64_t next_second_ns;
  int64_t played_ns; /* when the player was seen to have ended, 0 */
  int second;
  struct loop_count loop; /* at the start; then what was added */
};

/* What others judge a recording by. */
struct session_result {
  int sources;
  uint64_t lost;
  int lost_is_all; /* 0: there may be more */
  struct loop_count loop;
};
struct session_result session_result(const struct session *s);

/* Opens all; nothing of it stays on failure, no file either. */
int session_open(struct session *s, const struct session_settings *settings, const struct source_spec *spec,
                 int sources, struct app_error *error);
/* Records until the duration is over, a signal comes, or the disk refuses. 0, or -1 with status 1: something
 * was lost or could not be written. */
int session_run(struct session *s, struct app_error *error);
void session_close(struct session *s);

#endif
