/* failing_calls.c: preloaded, it makes one call fail as on a disk that is full, so that tests can try every
 * place where writing a result may fail, without a disk of their own. Counted are the calls that make, fill
 * and name result files (those whose name holds ".tmp-"); number $FAILING_CALL of them fails with ENOSPC. */
#define _GNU_SOURCE

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

typedef int open_function(const char *, int, ...);
typedef ssize_t write_function(int, const void *, size_t);
typedef int fsync_function(int);
typedef int rename_function(const char *, const char *);

/* the function that this one stands before; POSIX's way to get it from dlsym */
#define REAL(type, name)                                                                                     \
  static type *real;                                                                                         \
  if (!real) *(void **)&real = dlsym(RTLD_NEXT, name)

static int fails_now(const char *path) {
  static int calls;
  const char *wanted = getenv("FAILING_CALL");
  if (!wanted || !strstr(path, ".tmp-") || ++calls != atoi(wanted)) return 0;
  errno = ENOSPC;
  return 1;
}

static int fails_now_fd(int fd) {
  char name[64], path[4096];
  snprintf(name, sizeof name, "/proc/self/fd/%d", fd);
  const ssize_t n = readlink(name, path, sizeof path - 1);
  path[n > 0 ? n : 0] = '\0';
  return fails_now(path);
}

/* with file offsets of 64 bits a program calls open64 */
int open64(const char *path, int flags, ...) {
  REAL(open_function, "open64");
  mode_t mode = 0;
  if (flags & O_CREAT) {
    va_list arguments;
    va_start(arguments, flags);
    mode = va_arg(arguments, mode_t);
    va_end(arguments);
  }
  return fails_now(path) ? -1 : real(path, flags, mode);
}

ssize_t write(int fd, const void *bytes, size_t n) {
  REAL(write_function, "write");
  return fails_now_fd(fd) ? -1 : real(fd, bytes, n);
}

int fsync(int fd) {
  REAL(fsync_function, "fsync");
  return fails_now_fd(fd) ? -1 : real(fd);
}

int rename(const char *from, const char *to) {
  REAL(rename_function, "rename");
  return fails_now(from) ? -1 : real(from, to);
}
