/* writer.h: the one thread that writes: takes from all rings in order of time, makes lines of it. */
#ifndef WRITER_H
#define WRITER_H

#include "file_pair.h"
#include "source.h"

enum { MAX_SOURCES = 64 };

/* What the writer knows about one source. */
struct written {
  uint64_t frames;  /* lines in the log */
  uint64_t edges;   /* lines of edges */
  uint64_t errors;  /* error frames */
  uint64_t lost[2]; /* by enum item_where; for GPIO lines lost[0] */
  uint64_t stops, stops_failed;
  int64_t last_ns;    /* stamp of the last frame in the log */
  uint64_t backwards; /* frames whose stamp is before their predecessor's */
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
};

void writer_init(struct writer *w, struct file_pair *files, struct source *source, int sources,
                 struct ring *events);
/* Writes what is settled; with `all` everything that is in the rings. 0, or -1 when the disk refuses. */
int writer_cycle(struct writer *w, int all);
/* After a failure, with the readers ended: what is still in the rings counts as not written. */
void writer_give_up(struct writer *w);

#endif
