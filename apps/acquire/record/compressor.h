/* compressor.h: the files of a divided recording that are full, REC.log to REC.log.gz and so on, by a thread that nobody waits for.
 *
 * A file is taken up when the disk has confirmed it, and goes when the disk has confirmed the compressed one: at no time is a frame
 * in neither. The file that is being written stays as it is.
 */
#ifndef COMPRESSOR_H
#define COMPRESSOR_H

#include <stdint.h>
#include <zlib.h>

#include "common/error.h"
#include "file_pair.h"

enum { COMPRESSOR_BLOCK = 1 << 16, COMPRESSOR_PATH = 4096 };

struct compressor {
  const struct file_pair *files;
  z_stream stream;
  int is_open;
  int next;             /* number of the file that comes next */
  int done;             /* files compressed */
  int refused, failure; /* files that stayed as they were, and errno of the first one */
  int last;             /* set: end behind the file that is full now */
  int give_up;          /* set: end at once */
  int ended;            /* set by the thread */
  char plain[COMPRESSOR_PATH], packed[COMPRESSOR_PATH + 8], part[COMPRESSOR_PATH + 16];
  uint8_t in[COMPRESSOR_BLOCK], out[COMPRESSOR_BLOCK];
};

/* Takes all the memory that it will need. */
int compressor_open(struct compressor *c, const struct file_pair *files, struct app_error *error);
void compressor_close(struct compressor *c);
/* The thread's work: until `last` is set and nothing is left, or until `give_up`. */
void compressor_run(struct compressor *c);

#endif
