/* stream_block.h: what a stream is, and the memory of one block on its way (private to stream*.c). */
#ifndef STREAM_BLOCK_H
#define STREAM_BLOCK_H

#include "segments.h"
#include "stream.h"

struct stream {
  struct recording *recording;
  struct segments segments;
  tl_regression regression;
  double window_s[TL_MAX_JOINTS]; /* length of the windows, as it was opened */
  int rounding;                   /* of the angles, -1: none */
  int workers;                    /* that walk through it */
  const char *task;               /* what a walk is for */
};

/* Memory for one block, grown as blocks need it. Begins as zero. */
struct stream_room {
  size_t loaded;                    /* rows that the columns have room for */
  double *columns;                  /* TL_CHANNEL_COUNT arrays of so many */
  double *column[TL_CHANNEL_COUNT]; /* NULL for a channel that the regression does not read */
  size_t rows, grid;                /* that the space has room for */
  double *memory;
  tl_stop *stops;
  uint8_t *mask;
  tl_regression_space space;
};

/* Rows [from, to) of the recording into the room's columns. */
int stream_room_load(struct stream_room *room, const struct stream *s, size_t from, size_t to,
                     struct app_error *error);
/* Of what was loaded, n rows from the first-th on. */
tl_block stream_room_block(const struct stream_room *room, size_t first, size_t n);
/* Space for a block of so many rows and instants of the even grid; what was loaded stays. */
int stream_room_space(struct stream_room *room, const struct stream *s, size_t rows, size_t grid,
                      struct app_error *error);
void stream_room_free(struct stream_room *room);

#endif
