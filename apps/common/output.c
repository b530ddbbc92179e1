/* output.c: written beside its place, then renamed. */
#define _XOPEN_SOURCE 700 /* realpath */

#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "number.h"

#define BUFFER 65536
#define ATTEMPTS 1000 /* at a temporary name that nobody has */

struct output {
  const char *path; /* as given, for messages */
  char *target;     /* the file that will be replaced; NULL when written directly */
  char *temporary;
  int fd;
  int broken; /* errno of the first failure, or 0 */
  size_t used;
  char buffer[BUFFER];
};

/* ---- opening -------------------------------------------------------------- */

static void destroy(struct output *out) {
  free(out->target);
  free(out->temporary);
  free(out);
}

/* a new file beside the target: "PATH.tmp-123-0" */
static int open_temporary(struct output *out, mode_t mode) {
  const size_t size = strlen(out->target) + 64;
  out->temporary = malloc(size);
  if (!out->temporary) return -1;
  for (int i = 0; i < ATTEMPTS; i++) {
    snprintf(out->temporary, size, "%s.tmp-%ld-%d", out->target, (long)getpid(), i);
    const int fd = open(out->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (fd >= 0 || errno != EEXIST) return fd;
  }
  return -1;
}

/* the file behind symbolic links is the one that is replaced */
static char *resolve(const char *path) {
  char *real = realpath(path, NULL);
  return real ? real : strdup(path);
}

static int open_target(struct output *out) {
  struct stat status;
  const int there = stat(out->path, &status) == 0;
  if (there && S_ISDIR(status.st_mode)) {
    errno = EISDIR;
    return -1;
  }
  if (there && !S_ISREG(status.st_mode)) return open(out->path, O_WRONLY | O_CLOEXEC);
  out->target = resolve(out->path);
  if (!out->target) return -1;
  return open_temporary(out, there ? status.st_mode & 0777 : 0666);
}

struct output *output_open(const char *path, struct app_error *error) {
  struct output *out = calloc(1, sizeof *out);
  if (!out) {
    app_fail(error, APP_FAILED, "out of memory");
    return NULL;
  }
  const int standard = !path || strcmp(path, "-") == 0;
  out->path = standard ? "standard output" : path;
  out->fd = standard ? dup(STDOUT_FILENO) : open_target(out);
  if (out->fd >= 0) return out;
  app_fail(error, APP_FAILED, "%s: cannot be written: %s", out->path, strerror(errno));
  destroy(out);
  return NULL;
}

int output_probe(const char *path, struct app_error *error) {
  struct stat status;
  if (strcmp(path, "-") == 0) return 0;
  if (stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode)) return 0;
  struct output *out = output_open(path, error);
  output_abandon(out);
  return out ? 0 : -1;
}

int output_same(const char *path, const char *other) {
  struct stat a, b;
  const int there = stat(path, &a) == 0;
  if (there != (stat(other, &b) == 0)) return 0;
  if (!there) return strcmp(path, other) == 0;
  return S_ISREG(a.st_mode) && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

/* ---- writing -------------------------------------------------------------- */

static void write_all(struct output *out, const char *byte, size_t n) {
  while (n > 0 && !out->broken) {
    const ssize_t done = write(out->fd, byte, n);
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) {
      out->broken = errno;
      return;
    }
    byte += done;
    n -= (size_t)done;
  }
}

static void flush(struct output *out) {
  write_all(out, out->buffer, out->used);
  out->used = 0;
}

void output_bytes(struct output *out, const void *bytes, size_t n) {
  if (n > BUFFER - out->used) flush(out);
  if (n > BUFFER) {
    write_all(out, bytes, n);
    return;
  }
  memcpy(out->buffer + out->used, bytes, n);
  out->used += n;
}

void output_text(struct output *out, const char *text) {
  output_bytes(out, text, strlen(text));
}

void output_printf(struct output *out, const char *format, ...) {
  char text[2048];
  va_list arguments;
  va_start(arguments, format);
  const int n = vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  if (n < 0 || (size_t)n >= sizeof text) {
    if (!out->broken) out->broken = EOVERFLOW;
    return;
  }
  output_bytes(out, text, (size_t)n);
}

void output_number(struct output *out, double x) {
  char text[NUMBER_TEXT];
  output_bytes(out, text, number_rounded(text, x));
}

void output_exact(struct output *out, double x) {
  char text[NUMBER_TEXT];
  output_bytes(out, text, number_exact(text, x));
}

void output_row(struct output *out, double t_s, const double *value, size_t n) {
  output_exact(out, t_s);
  for (size_t i = 0; i < n; i++) {
    output_bytes(out, ",", 1);
    output_number(out, value[i]);
  }
  output_bytes(out, "\n", 1);
}

/* ---- ending --------------------------------------------------------------- */

/* so that the new name survives a power failure; where a folder cannot be synced, it need not be */
static void sync_folder(const char *target) {
  char *copy = strdup(target);
  if (!copy) return;
  const int fd = open(dirname(copy), O_RDONLY | O_CLOEXEC);
  if (fd >= 0) {
    fsync(fd);
    close(fd);
  }
  free(copy);
}

static int finish(struct output *out) {
  flush(out);
  if (!out->broken && out->target && fsync(out->fd) != 0) out->broken = errno;
  if (close(out->fd) != 0 && !out->broken) out->broken = errno;
  if (!out->broken && out->target && rename(out->temporary, out->target) != 0) out->broken = errno;
  if (out->broken && out->temporary) unlink(out->temporary);
  if (!out->broken && out->target) sync_folder(out->target);
  return out->broken;
}

int output_commit(struct output *out, struct app_error *error) {
  const int failure = finish(out);
  const int result =
      failure ? app_fail(error, APP_FAILED, "%s: cannot be written: %s", out->path, strerror(failure)) : 0;
  destroy(out);
  return result;
}

void output_abandon(struct output *out) {
  if (!out) return;
  close(out->fd);
  if (out->temporary) unlink(out->temporary);
  destroy(out);
}
