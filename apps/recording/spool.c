/* spool.c: rows in an unlinked temporary file. */
#include "spool.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

#define SPOOL_BUFFER 32768 /* doubles: 256 KiB */

struct spool {
  int fd;
  size_t width;
  size_t capacity;    /* rows that the buffer holds */
  size_t first, held; /* rows [first, first + held) of the file stand in it */
  char folder[512];
  double buffer[SPOOL_BUFFER];
};

/* an open file without a name in `folder`, or -1 */
static int open_unnamed(const char *folder) {
  char name[600];
  const int n = snprintf(name, sizeof name, "%s/talus-XXXXXX", folder);
  if (n < 0 || (size_t)n >= sizeof name) return -1;
  const int fd = mkstemp(name);
  if (fd >= 0) unlink(name);
  return fd;
}

static int open_anywhere(struct spool *spool, struct app_error *error) {
  const char *const folders[] = {getenv("TMPDIR"), "/var/tmp", "/tmp"};
  for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++) {
    const size_t length = folders[i] ? strlen(folders[i]) : 0;
    if (length == 0 || length >= sizeof spool->folder) continue;
    memcpy(spool->folder, folders[i], length + 1);
    spool->fd = open_unnamed(folders[i]);
    if (spool->fd >= 0) return 0;
  }
  return app_fail(error, APP_FAILED, "no temporary file in $TMPDIR, /var/tmp or /tmp: %s", strerror(errno));
}

struct spool *spool_open(size_t width, struct app_error *error) {
  struct spool *spool = malloc(sizeof *spool);
  if (!spool) {
    app_fail(error, APP_FAILED, "out of memory");
    return NULL;
  }
  spool->width = width;
  spool->capacity = SPOOL_BUFFER / width;
  spool->first = spool->held = 0;
  if (open_anywhere(spool, error) != 0) {
    free(spool);
    return NULL;
  }
  return spool;
}

void spool_close(struct spool *spool) {
  if (!spool) return;
  close(spool->fd);
  free(spool);
}

int spool_write(const struct spool *spool, size_t at, const double *row, size_t n, struct app_error *error) {
  const size_t row_bytes = spool->width * sizeof(double);
  const char *byte = (const char *)row;
  size_t left = n * row_bytes;
  off_t offset = (off_t)(at * row_bytes);
  while (left > 0) {
    const ssize_t done = pwrite(spool->fd, byte, left, offset);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0)
      return app_fail(error, APP_FAILED, "cannot write a temporary file in %s: %s", spool->folder,
                      strerror(errno));
    byte += done;
    left -= (size_t)done;
    offset += done;
  }
  return 0;
}

/* rows [from, from + n) into the buffer */
static int load(struct spool *spool, size_t from, size_t n, struct app_error *error) {
  const size_t row_bytes = spool->width * sizeof(double);
  char *byte = (char *)spool->buffer;
  size_t left = n * row_bytes;
  off_t offset = (off_t)(from * row_bytes);
  spool->held = 0;
  while (left > 0) {
    const ssize_t got = pread(spool->fd, byte, left, offset);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      return app_fail(error, APP_FAILED, "cannot read the temporary file in %s: %s", spool->folder,
                      got < 0 ? strerror(errno) : "it ended too early");
    byte += got;
    left -= (size_t)got;
    offset += got;
  }
  spool->first = from;
  spool->held = n;
  return 0;
}

int spool_read(struct spool *spool, size_t from, size_t n, const double **row, size_t *rows,
               struct app_error *error) {
  if (from < spool->first || from >= spool->first + spool->held) {
    if (load(spool, from, n < spool->capacity ? n : spool->capacity, error) != 0) return -1;
  }
  const size_t skipped = from - spool->first;
  const size_t there = spool->held - skipped;
  *row = spool->buffer + skipped * spool->width;
  *rows = n < there ? n : there;
  return 0;
}
