/* log_summary.h: what stands in a record's log (candump's format, also compressed), in one pass and little memory.
 *
 *     struct log_summary *s = log_summary_read("walk.log", &error);
 *     for (int i = 0; i < s->messages; i++) s->message[i].frames ...
 *     free(s);
 */
#ifndef LOG_SUMMARY_H
#define LOG_SUMMARY_H

#include <stdint.h>

#include "common/error.h"

enum { LOG_NAME = 16, LOG_MESSAGES = 4096 };

struct log_message {
  char name[LOG_NAME]; /* the interface; longer names are cut */
  uint32_t id;
  int extended;
  uint64_t frames, backwards; /* stamped before the frame above */
  int64_t first_ns, last_ns;
  int64_t longest_ns; /* between two of its frames, and the stamp before it */
  int64_t longest_at_ns;
};

struct log_summary {
  uint64_t lines, frames, errors, remote;
  uint64_t no_frames, first_no_frame; /* lines that are none, and the number of the first */
  uint64_t uncounted;                 /* frames of further messages, when there are too many */
  int cut;                            /* the last line is no whole one */
  int files;                          /* in which the record stands */
  int64_t first_ns, last_ns;          /* earliest and latest stamp */
  int messages;
  struct log_message message[LOG_MESSAGES]; /* by interface and identifier */
};

/* NULL with status 2 when it cannot be read. */
struct log_summary *log_summary_read(const char *path, struct app_error *error);

#endif
