/* file_pair.c: appending whole lines. */
#define _GNU_SOURCE

#include "file_pair.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { LOG_BUFFER = 1 << 20, JSON_BUFFER = 1 << 18, RESERVE = 1 << 16 };

static const char *const suffix[] = {".log", ".jsonl"};

static char *path_of(const char *out, enum file_name which) {
  const size_t n = strlen(out), cut = n > 4 && strcmp(out + n - 4, ".log") == 0 ? n - 4 : n;
  char *path = malloc(cut + 8);
  if (path) snprintf(path, cut + 8, "%.*s%s", (int)cut, out, suffix[which]);
  return path;
}

/* a folder, a device, a pipe whose other end nobody reads */
static int is_no_file(const char *path) {
  struct stat found;
  return stat(path, &found) == 0 && !S_ISREG(found.st_mode);
}

/* a recording that was divided, of the same name: its files would be read as if they were this one's */
static int refuse_series(const char *log, int overwrite, struct app_error *error) {
  char path[4096];
  for (int part = 0; series_find(path, sizeof path, log, part) == 0; part++) {
    if (strcmp(path, log) == 0) continue; /* is looked at when it is opened */
    if (!overwrite)
      return app_fail(error, APP_BAD_INPUT, "%s: is there already (--overwrite replaces it)", path);
    if (unlink(path) != 0)
      return app_fail(error, APP_FAILED, "%s: cannot be replaced: %s", path, strerror(errno));
  }
  return 0;
}

/* names that would make a hidden ".log" */
static int has_name(const char *out) {
  const char *slash = strrchr(out, '/'), *name = slash ? slash + 1 : out;
  return *name && strcmp(name, ".log") != 0 && strcmp(name, ".") != 0 && strcmp(name, "..") != 0;
}

static int open_one(struct file_pair *pair, enum file_name which, const char *out, int overwrite,
                    struct app_error *error) {
  const size_t size = which == FILE_LOG ? LOG_BUFFER : JSON_BUFFER;
  char *path = pair->file[which].path = path_of(out, which);
  struct text *text = &pair->file[which].text;
  *text = (struct text){calloc(1, size), 0, size};
  if (!path || !text->at) return app_fail(error, APP_FAILED, "out of memory");
  memset(text->at, ' ', size); /* the pages are there from now on */
  if (is_no_file(path)) return app_fail(error, APP_BAD_INPUT, "%s: is there, and is no file", path);
  if (which == FILE_LOG && refuse_series(path, overwrite, error) != 0) return -1;
  const int flags = O_WRONLY | O_CREAT | O_CLOEXEC | O_APPEND | O_NONBLOCK | (overwrite ? O_TRUNC : O_EXCL);
  pair->file[which].fd = open(path, flags, 0666);
  if (pair->file[which].fd >= 0) return 0;
  if (errno == EEXIST)
    return app_fail(error, APP_BAD_INPUT, "%s: is there already (--overwrite replaces it)", path);
  return app_fail(error, APP_FAILED, "%s: cannot be written: %s", path, strerror(errno));
}

/* an unnamed file in the same folder, whose room is freed when the disk is full */
static int open_reserve(const char *path) {
  char *copy = strdup(path);
  if (!copy) return -1;
  const int fd = open(dirname(copy), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
  free(copy);
  if (fd >= 0 && posix_fallocate(fd, 0, RESERVE) != 0) {
    close(fd);
    return -1;
  }
  return fd;
}

/* the names survive a power cut */
static void sync_folder(const char *path) {
  char *copy = strdup(path);
  if (!copy) return;
  const int fd = open(dirname(copy), O_RDONLY | O_CLOEXEC);
  free(copy);
  if (fd < 0) return;
  fsync(fd);
  close(fd);
}

int file_pair_open(struct file_pair *pair, const char *out, int overwrite, struct app_error *error) {
  memset(pair, 0, sizeof *pair);
  pair->reserve = pair->full = pair->folder = pair->file[FILE_LOG].fd = pair->file[FILE_JSON].fd = -1;
  if (!has_name(out))
    return app_fail(error, APP_BAD_INPUT, "--out: expected a file's name, found '%.200s'", out);
  for (int i = 0; i < FILES; i++) {
    if (open_one(pair, (enum file_name)i, out, overwrite, error) == 0) continue;
    if (i == FILE_JSON) unlink(pair->file[FILE_LOG].path); /* empty, and ours */
    return -1;
  }
  pair->reserve = open_reserve(pair->file[FILE_LOG].path);
  sync_folder(pair->file[FILE_LOG].path);
  return 0;
}

void file_pair_close(struct file_pair *pair) {
  file_pair_release(pair);
  if (pair->full >= 0) close(pair->full);
  if (pair->folder >= 0) close(pair->folder);
  free(pair->part_path);
  for (int i = 0; i < FILES; i++) {
    if (pair->file[i].fd >= 0) close(pair->file[i].fd);
    free(pair->file[i].text.at);
    free(pair->file[i].path);
  }
}

void file_pair_release(struct file_pair *pair) {
  if (pair->reserve >= 0) close(pair->reserve);
  pair->reserve = -1;
}

int file_pair_failure(const struct file_pair *pair) {
  return __atomic_load_n(&pair->failure, __ATOMIC_ACQUIRE);
}

/* the first one counts */
static void fail(struct file_pair *pair, enum file_name which, int reason) {
  int none = 0;
  if (__atomic_compare_exchange_n(&pair->failure, &none, reason, 0, __ATOMIC_ACQ_REL, __ATOMIC_ACQUIRE))
    __atomic_store_n(&pair->failed_in, (int)which, __ATOMIC_RELEASE);
}

static int sync_one(struct file_pair *pair, enum file_name which, int fd) {
  while (fdatasync(fd) != 0) {
    if (errno == EINTR) continue;
    if (errno == EINVAL || errno == ENOSYS) return 0; /* a file system that knows no such thing */
    fail(pair, which, errno);
    __atomic_store_n(&pair->sync_failed, 1, __ATOMIC_RELEASE);
    return -1;
  }
  return 0;
}

/* The file before the present one is looked at last: what had been handed to the kernel before is in one of the two, also when the
 * present one is full in between. */
int file_pair_sync(struct file_pair *pair, enum file_name which) {
  if (__atomic_load_n(&pair->sync_failed, __ATOMIC_ACQUIRE)) return -1;
  if (sync_one(pair, which, __atomic_load_n(&pair->file[which].fd, __ATOMIC_ACQUIRE)) != 0) return -1;
  const int full = which == FILE_LOG ? __atomic_load_n(&pair->full, __ATOMIC_ACQUIRE) : -1;
  if (full < 0) return 0;
  if (sync_one(pair, which, full) != 0) return -1;
  if (pair->folder >= 0) fsync(pair->folder);
  close(full);
  __atomic_store_n(&pair->settled, pair->settled + 1, __ATOMIC_RELEASE);
  __atomic_store_n(&pair->full, -1, __ATOMIC_RELEASE);
  return 0;
}

/* ---- a log that is divided ----------------------------------------------------------------- */

void file_pair_divide(struct file_pair *pair, struct series_limit limit) {
  char *copy = strdup(pair->file[FILE_LOG].path);
  pair->part_size = strlen(pair->file[FILE_LOG].path) + 16;
  pair->part_path = calloc(1, pair->part_size);
  if (copy) pair->folder = open(dirname(copy), O_RDONLY | O_CLOEXEC);
  free(copy);
  if (pair->part_path) pair->limit = limit;
}

static int is_due(struct file_pair *pair, int64_t now_ns) {
  if (pair->since_ns == 0) pair->since_ns = now_ns;
  const int large = pair->limit.bytes && pair->file[FILE_LOG].written >= pair->limit.bytes;
  return large || (pair->limit.ns && now_ns - pair->since_ns >= pair->limit.ns);
}

int file_pair_next(struct file_pair *pair, int64_t now_ns) {
  if (!is_due(pair, now_ns) || __atomic_load_n(&pair->full, __ATOMIC_ACQUIRE) >= 0) return 0;
  series_path(pair->part_path, pair->part_size, pair->file[FILE_LOG].path, pair->part + 1);
  const int fd = open(pair->part_path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_APPEND, 0666);
  if (fd < 0) {
    pair->refused = errno;
    return -1;
  }
  const int full = pair->file[FILE_LOG].fd;
  __atomic_store_n(&pair->full, full, __ATOMIC_RELEASE); /* first: at no time is it in neither */
  __atomic_store_n(&pair->file[FILE_LOG].fd, fd, __ATOMIC_RELEASE);
  pair->file[FILE_LOG].written = 0;
  pair->since_ns = now_ns;
  pair->part++;
  pair->refused = 0;
  return 1;
}

/* ---- writing ------------------------------------------------------------------------------- */

/* After `done` of the text's bytes: the rest of a cut line goes from the file, and what is whole in it goes
 * from the text. */
static void cut_behind_last_line(struct file_pair *pair, enum file_name which, size_t done) {
  struct text *t = &pair->file[which].text;
  while (done > 0 && t->at[done - 1] != '\n') done--;
  pair->file[which].written += (int64_t)done;
  memmove(t->at, t->at + done, t->used - done);
  t->used -= done;
  if (ftruncate(pair->file[which].fd, (off_t)pair->file[which].written) != 0) return; /* then a part stays */
}

int file_pair_flush(struct file_pair *pair, enum file_name which) {
  struct text *t = &pair->file[which].text;
  size_t done = 0;
  while (done < t->used) {
    const ssize_t n = write(pair->file[which].fd, t->at + done, t->used - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      fail(pair, which, errno);
      cut_behind_last_line(pair, which, done);
      return -1;
    }
    done += (size_t)n;
  }
  pair->file[which].written += (int64_t)done;
  t->used = 0;
  return 0;
}
