/* progress.h: one line on standard error that tells how far a long step is, where somebody watches.
 *
 *     struct progress progress;
 *     progress_begin(&progress, "reading", path);
 *     while (...) progress_update(&progress, done / (double)all);
 *     progress_end(&progress);
 *
 * Nothing is written unless the program has asked for it (progress_show) and standard error is a terminal, and then at
 * most ten times a second. The line is gone after progress_end, which must come before any other message.
 */
#ifndef PROGRESS_H
#define PROGRESS_H

/* 1: what is begun from now on is shown; 0 at first, for one who reads files through the library has a screen of his own. */
void progress_show(int shown);

struct progress {
  char what[80];
  int shown;     /* standard error is a terminal */
  int drawn;     /* the line stands there */
  double last_s; /* when it was drawn */
};

/* Nullable: path, of the file that is worked on. */
void progress_begin(struct progress *progress, const char *task, const char *path);
/* fraction 0..1; from any thread, but not from two at once */
void progress_update(struct progress *progress, double fraction);
void progress_end(struct progress *progress);

#endif
