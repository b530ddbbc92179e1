/* file_pair.h: the record's two files, REC.log and REC.jsonl, written so that a kill loses little.
 *
 * They appear under their own names at once: a recording must be there whatever happens to the program.
 * Only whole lines are handed to the kernel; after a failed write the file is cut behind its last whole line.
 */
#ifndef FILE_PAIR_H
#define FILE_PAIR_H

#include "common/error.h"
#include "text.h"

enum file_name { FILE_LOG, FILE_JSON, FILES };

struct file_pair {
  struct {
    char *path;
    int fd;
    struct text text;
    int64_t written; /* bytes of whole lines */
  } file[FILES];
  int reserve;   /* holds some of the disk's room for the last lines */
  int failure;   /* errno of the first failed write, 0 */
  int failed_in; /* enum file_name */
};

/* `out` with or without ".log". Existing files are refused unless `overwrite`. */
int file_pair_open(struct file_pair *pair, const char *out, int overwrite, struct app_error *error);
void file_pair_close(struct file_pair *pair);

/* The text of one file to the kernel; 0, or -1 and `failure` is set: then the text holds what is not in the
 * file. After a failure of the log, the JSON lines can still be written. */
int file_pair_flush(struct file_pair *pair, enum file_name which);
/* Gives the reserved room back to the disk. */
void file_pair_release(struct file_pair *pair);
/* To the disk itself. May take long. */
void file_pair_sync(const struct file_pair *pair);

#endif
