/* series.h: the files of a recording that is divided: REC.log, REC.001.log, REC.002.log, ...
 *
 * A series is read from its first file; it goes on as long as the next number is there.
 */
#ifndef SERIES_H
#define SERIES_H

#include <stddef.h>
#include <stdint.h>

/* When the next file begins: after so many bytes, or so many nanoseconds. 0 is never. */
struct series_limit {
  int64_t bytes, ns;
};

/* "100M" (k, M, G: bytes) or "15min" (s, min, h); 0, or -1. At least 4k, at least a second. */
int series_limit_parse(const char *text, struct series_limit *limit);

/* The name of a file of the series: `log` is its first, with or without .log or .log.gz; number 0 is `log` itself. */
void series_path(char *path, size_t size, const char *log, int number);
/* The same for reading: also with .gz behind it, where only that is there. -1 when there is no such file, but for the first, which is
 * what was asked for. */
int series_find(char *path, size_t size, const char *log, int number);

#endif
