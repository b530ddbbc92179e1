/* failing_disk.c: preloaded, it is a disk that takes all writes into memory and fails behind them, as a thin device does that
 * is full, or a memory card that dies. At call number $FAILING_SYNC on files whose names end with
 * $FAILING_NAME ("*.log"), fdatasync answers EIO once; what
 * was not on the disk until then is gone from the file, and later calls succeed, as the kernel does it. */
#define _GNU_SOURCE

#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef int sync_function(int);

static int is_meant(int fd) {
  char name[64], path[4096];
  const char *end = getenv("FAILING_NAME") ? getenv("FAILING_NAME") : ".log";
  snprintf(name, sizeof name, "/proc/self/fd/%d", fd);
  const ssize_t n = readlink(name, path, sizeof path - 1);
  path[n > 0 ? n : 0] = '\0';
  return n > (ssize_t)strlen(end) && strcmp(path + n - strlen(end), end) == 0;
}

enum { FILES = 64 };

/* how much of a file is on the disk */
static off_t *on_disk(ino_t file) {
  static struct {
    ino_t file;
    off_t size;
  } known[FILES];
  int i = 0;
  while (i < FILES - 1 && known[i].file && known[i].file != file) i++;
  known[i].file = file;
  return &known[i].size;
}

int fdatasync(int fd) {
  static sync_function *real;
  static int calls;
  struct stat found;
  const char *wanted = getenv("FAILING_SYNC");
  if (!real) *(void **)&real = dlsym(RTLD_NEXT, "fdatasync");
  if (!wanted || !is_meant(fd) || fstat(fd, &found) != 0) return real(fd);
  if (++calls != atoi(wanted)) {
    *on_disk(found.st_ino) = found.st_size;
    return real(fd);
  }
  if (ftruncate(fd, *on_disk(found.st_ino)) != 0) return real(fd);
  errno = EIO;
  return -1;
}
