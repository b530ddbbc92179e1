/* file_pair.h: the record's two files, REC.log and REC.jsonl, written so that a kill loses little.
 *
 * They appear under their own names at once: a recording must be there whatever happens to the program.
 * Only whole lines are handed to the kernel; after a failed write the file is cut behind its last whole line.
 */
#ifndef FILE_PAIR_H
#define FILE_PAIR_H

#include "common/error.h"
#include "series.h"
#include "text.h"

enum file_name { FILE_LOG, FILE_JSON, FILES };

struct file_pair {
  struct {
    char *path;
    int fd;
    struct text text;
    int64_t written; /* bytes of whole lines */
  } file[FILES];
  int reserve;     /* holds some of the disk's room for the last lines */
  int failure;     /* errno of the first write or sync that failed, 0; whoever sees it first sets it */
  int failed_in;   /* enum file_name */
  int sync_failed; /* the kernel has thrown away what it could not write, and says so only once */

  /* a log that is divided; the JSON file is not */
  struct series_limit limit;
  int part;         /* number of the file that is being written */
  int64_t since_ns; /* when it was begun */
  char *part_path;  /* room for its name */
  size_t part_size;
  int full; /* the file before it, until it is on the disk; -1 none. Closed by whoever syncs */
  int settled; /* files that are full and on the disk: numbers 0 to settled - 1. By whoever syncs */
  int folder;
  int refused; /* errno why the next file could not be begun, 0 */
};

/* `out` with or without ".log". Existing files are refused unless `overwrite`, what is no file always. */
int file_pair_open(struct file_pair *pair, const char *out, int overwrite, struct app_error *error);
void file_pair_close(struct file_pair *pair);
/* From now on the log is divided. */
void file_pair_divide(struct file_pair *pair, struct series_limit limit);
/* Begins the log's next file where it is time to, behind whole lines: 1 done, 0 not yet, -1 it cannot be begun (`refused`), and the
 * present one goes on. By the thread that writes. */
int file_pair_next(struct file_pair *pair, int64_t now_ns);

/* The text of one file to the kernel; 0, or -1 and `failure` is set: then the text holds what is not in the
 * file. After a failure of the log, the JSON lines can still be written. */
int file_pair_flush(struct file_pair *pair, enum file_name which);
/* Gives the reserved room back to the disk. */
void file_pair_release(struct file_pair *pair);
/* One file to the disk itself, which may take long; 0, or -1 and `failure` is set: what was written since the last time
 * may be lost. */
int file_pair_sync(struct file_pair *pair, enum file_name which);
/* The failure so far, 0 none; by any thread. */
int file_pair_failure(const struct file_pair *pair);

#endif
