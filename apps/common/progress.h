/* progress.h: one line on standard error that tells how far a long step is, where somebody watches.
 *
 *     struct progress progress;
 *     progress_begin(&progress, "identifying");
 *     while (...) progress_update(&progress, done / (double)all);
 *     progress_end(&progress);
 *
 * Nothing is written unless standard error is a terminal, and then at most ten times a second. The line
 * is gone after progress_end, which must come before any other message.
 */
#ifndef PROGRESS_H
#define PROGRESS_H

struct progress {
  const char *what; /* the caller's */
  int shown;        /* standard error is a terminal */
  int drawn;        /* the line stands there */
  double last_s;    /* when it was drawn */
};

void progress_begin(struct progress *progress, const char *what);
/* fraction 0..1 */
void progress_update(struct progress *progress, double fraction);
void progress_end(struct progress *progress);

#endif
