/* progress.c: a line that draws over itself. */
#include "progress.h"

#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "error.h"

#define INTERVAL_S 0.1
#define NAME_BYTES 48 /* of a file's name: with program and task it stays on one line of a terminal */

static int allowed;

void progress_show(int shown) {
  allowed = shown;
}

static double now_s(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* the task, and of a path the file's name */
static void describe(struct progress *progress, const char *task, const char *path) {
  const char *slash = path ? strrchr(path, '/') : NULL;
  const char *file = slash ? slash + 1 : path ? path : "";
  char name[NAME_BYTES];
  snprintf(progress->what, sizeof progress->what, "%s%s%s", task, *file ? " " : "",
           app_printable(name, sizeof name, file, strlen(file)));
}

void progress_begin(struct progress *progress, const char *task, const char *path) {
  describe(progress, task, path);
  progress->shown = allowed && isatty(STDERR_FILENO);
  progress->drawn = 0;
  progress->last_s = progress->shown ? now_s() : 0.0;
}

void progress_update(struct progress *progress, double fraction) {
  if (!progress->shown) return;
  const double time_s = now_s();
  if (time_s - progress->last_s < INTERVAL_S) return;
  progress->last_s = time_s;
  progress->drawn = 1;
  fprintf(stderr, "\r%s: %s %3.0f %%", app_name(), progress->what, 100.0 * fraction);
  fflush(stderr);
}

void progress_end(struct progress *progress) {
  if (progress->drawn) fprintf(stderr, "\r\033[K");
  progress->drawn = 0;
}
