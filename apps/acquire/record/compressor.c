/* compressor.c: gzip, file by file. */
#define _GNU_SOURCE

#include "compressor.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "acquire/host/clocks.h"

enum {
  LEVEL = 3,      /* keeps up with any bus on a small processor */
  GZIP = 15 + 16, /* the window, with gzip's header */
  MEMORY = 8,     /* zlib's usual */
  NICEST = 19,
  POLL_NS = 100000000
};

int compressor_open(struct compressor *c, const struct file_pair *files, struct app_error *error) {
  memset(c, 0, sizeof *c);
  c->files = files;
  if (deflateInit2(&c->stream, LEVEL, Z_DEFLATED, GZIP, MEMORY, Z_DEFAULT_STRATEGY) != Z_OK)
    return app_fail(error, APP_FAILED, "out of memory");
  c->is_open = 1;
  return 0;
}

void compressor_close(struct compressor *c) {
  if (c->is_open) deflateEnd(&c->stream);
  c->is_open = 0;
}

static int is_set(const int *flag) {
  return __atomic_load_n(flag, __ATOMIC_ACQUIRE);
}

static int write_all(int fd, const uint8_t *at, size_t left) {
  while (left) {
    const ssize_t n = write(fd, at, left);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return -1;
    at += n;
    left -= (size_t)n;
  }
  return 0;
}

/* what there is to write of the block that was given */
static int put_block(struct compressor *c, int fd, int flush) {
  do {
    c->stream.next_out = c->out;
    c->stream.avail_out = sizeof c->out;
    deflate(&c->stream, flush);
    if (write_all(fd, c->out, sizeof c->out - c->stream.avail_out) != 0) return -1;
  } while (c->stream.avail_out == 0);
  return 0;
}

static int pack(struct compressor *c, int from, int to) {
  ssize_t n;
  deflateReset(&c->stream);
  do {
    if (is_set(&c->give_up)) {
      errno = ECANCELED;
      return -1;
    }
    n = read(from, c->in, sizeof c->in);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return -1;
    c->stream.next_in = c->in;
    c->stream.avail_in = (uInt)n;
    if (put_block(c, to, n ? Z_NO_FLUSH : Z_FINISH) != 0) return -1;
  } while (n != 0);
  return fdatasync(to);
}

/* the compressed file under the name `part`; 0, or -1 and errno */
static int make_part(struct compressor *c) {
  const int from = open(c->plain, O_RDONLY | O_CLOEXEC);
  if (from < 0) return -1;
  const int to = open(c->part, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  int result = to < 0 ? -1 : pack(c, from, to), reason = errno;
  close(from);
  if (to >= 0 && close(to) != 0 && result == 0) {
    result = -1;
    reason = errno;
  }
  errno = reason;
  return result;
}

/* the new name is on the disk before the old one goes */
static int replace(const struct compressor *c) {
  if (access(c->packed, F_OK) == 0) {
    errno = EEXIST;
    return -1;
  }
  if (rename(c->part, c->packed) != 0) return -1;
  if (c->files->folder >= 0 && fsync(c->files->folder) != 0) return -1;
  return unlink(c->plain);
}

static void compress_one(struct compressor *c, int number) {
  series_path(c->plain, sizeof c->plain, c->files->file[FILE_LOG].path, number);
  snprintf(c->packed, sizeof c->packed, "%s.gz", c->plain);
  snprintf(c->part, sizeof c->part, "%s.part", c->packed);
  if (make_part(c) == 0 && replace(c) == 0) {
    c->done++;
    return;
  }
  if (!c->failure) c->failure = errno;
  c->refused++;
  unlink(c->part);
}

void compressor_run(struct compressor *c) {
  setpriority(PRIO_PROCESS, 0, NICEST); /* of this thread alone, on Linux */
  while (!is_set(&c->give_up)) {
    const int last = is_set(&c->last);
    if (c->next < __atomic_load_n(&c->files->settled, __ATOMIC_ACQUIRE))
      compress_one(c, c->next++);
    else if (last)
      break;
    else
      clock_sleep_until(clock_mono_ns() + POLL_NS);
  }
  __atomic_store_n(&c->ended, 1, __ATOMIC_RELEASE);
}
