/* candump_lines.h: lines of candump's log format, as columns.
 *
 *     struct candump_lines b = {.text = text, .size = n, .time_ns = time_ns, ...};
 *     int found;
 *     while ((found = candump_lines_read(&b)) > 0) look_at(text + b.begin, b.end - b.begin); // holds no frame
 *
 * A line is "(SECONDS.FRACTION) NAME ID#DATA", with "R" or "##" and a flag before the data of remote and CAN FD frames, and
 * perhaps a direction behind them (" R", " T").
 */
#ifndef CANDUMP_LINES_H
#define CANDUMP_LINES_H

#include <stddef.h>
#include <stdint.h>

enum { CANDUMP_BYTES = 64, CANDUMP_SHORTEST = 12 /* characters of a frame */, CANDUMP_NAMES = 1000 };

/* An interface: where its name stands first, and the least order of its lines. */
struct candump_name {
  size_t at, n;
  uint64_t least;
};

struct candump_lines {
  const char *text; /* whole lines */
  size_t size;
  size_t at, begin, end;         /* where the next line begins; the last one */
  int64_t lines, remote, errors; /* counted */
  int64_t frames, widest;        /* rows of the columns; most bytes of data */
  int64_t *time_ns, *identifier; /* 1 << 31 is set in one of 29 bits */
  int64_t *line;                 /* counted from 1 */
  uint16_t *name;                /* of `names` */
  uint8_t *length, *data;        /* CANDUMP_BYTES of each, zero before */
  int64_t names;                 /* of lines that hold frames */
  struct candump_name found[CANDUMP_NAMES];
};

/* Reads on; the columns have room for all frames. 0: to the end; 1: up to a line that holds no frame, and is not blank; -1: there
 * are too many names. */
int candump_lines_read(struct candump_lines *b);

#endif
