/* writer.h: the one thread that writes: takes from all rings in order of time, makes lines of it. */
#ifndef WRITER_H
#define WRITER_H

#include "account.h"
#include "acquire/source/source.h"
#include "file_pair.h"

enum { MAX_SOURCES = 64 };

/* Emergency stops: all, those of which some frames did not go out, and those of which none did. */
struct writer_stops {
  uint64_t all, partial, failed;
};

/* What the writer knows about one source. */
struct written {
  uint64_t frames;       /* lines in the log */
  uint64_t edges;        /* lines of edges */
  uint64_t pulses;       /* lines of pulses */
  uint64_t handed;       /* of the frames: handed to the kernel */
  uint64_t synced;       /* of these: on the disk. By the thread that syncs */
  uint64_t not_written;  /* taken from the ring, and in no file */
  uint64_t errors;       /* error frames */
  uint64_t lost[2];      /* by enum item_where; for GPIO lines lost[0] */
  uint64_t perhaps_lost; /* besides, at most, of what interfaces had counted when they vanished */
  uint64_t not_known;    /* interfaces that vanished, of which nobody has counted what was on its way */
  struct writer_stops stops;
  int64_t last_ns;    /* stamp of the last frame in the log */
  uint64_t backwards; /* frames whose stamp is before their predecessor's */
  uint64_t estimated; /* frames without the adapter's stamp, put on its clock by the last one that had it */
  int64_t to_hardware_ns; /* adapter's clock less the kernel's, of the last frame that had both */
  struct bus bus;
  struct item error; /* the last error frame, while equal ones are counted */
  uint64_t error_count, error_after;
  int64_t error_last_ns;
  uint32_t old_head; /* what was in the ring some cycles ago is not held back any longer */
};

struct writer {
  struct file_pair *files;
  struct source *source;
  int sources;
  struct ring *events; /* the session's own */
  struct written state[MAX_SOURCES];
  uint32_t events_old;
  int cycle;
  uint64_t events_not_written; /* taken from a ring, or never put there, and in no file */
  int64_t last_ns;             /* realtime of the last frame in the log, of any source */
  uint64_t out_of_order;       /* frames in the log behind a later one of another interface */
};

void writer_init(struct writer *w, struct file_pair *files, struct source *source, int sources,
                 struct ring *events);
/* Writes what is settled; with `all` everything that is in the rings. 0, or -1 when the disk refuses. */
int writer_cycle(struct writer *w, int all);
/* After a failure, with the readers ended: what is still in the rings counts as not written, and so do the events that were
 * abandoned before them. */
void writer_give_up(struct writer *w, uint64_t abandoned);
/* After a failure, with all threads ended: says what the disk has not confirmed. */
void writer_tell_not_synced(struct writer *w);
/* What has been written, to the disk. On a thread of its own; 0, or -1 when the disk refuses. */
int writer_sync(struct writer *w);

/* A source's account, and what is lost of all of them; when all threads have ended. */
struct account writer_account(const struct writer *w, int source);
uint64_t writer_lost(const struct writer *w);
/* The emergency stops of all sources; when all threads have ended. */
struct writer_stops writer_stops(const struct writer *w);
/* Is that all that is lost? */
int writer_knows(const struct writer *w);

#endif
