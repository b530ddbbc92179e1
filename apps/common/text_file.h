/* text_file.h: a plain or gzip-compressed text file, read in blocks of whole lines.
 *
 *     struct text_file *file = text_file_open(path, &error);
 *     while ((more = text_file_read(file, block, &error)) > 0) ... lines in block->text[0 .. block->length)
 *     text_file_close(file);
 *
 * Memory is the block's and one line's, however long the file. What the file is,
 * its content says, not its name. Pipes can be read too.
 */
#ifndef TEXT_FILE_H
#define TEXT_FILE_H

#include <stddef.h>

#include "error.h"

#define TEXT_BLOCK 262144 /* bytes of a block, and of the longest line */
#define TEXT_PAD 64       /* bytes beyond the text that can be read, whatever they hold */

/* Lines, the last of which ends with a newline. */
struct text_block {
  size_t length;
  int unterminated; /* the file ends here and its last line had no newline: this one was added */
  int endless;      /* a line longer than a block: nothing was read, length is 0 */
  char text[TEXT_BLOCK + 1 + TEXT_PAD];
};

struct text_file;

/* NULL on failure: no such file, no permission, a directory. Owned by the caller;
 * `path` must outlive it. */
struct text_file *text_file_open(const char *path, struct app_error *error);
/* Nullable: file. */
void text_file_close(struct text_file *file);

/* The next lines: 1; 0 at the end of the file; -1 on failure (unreadable, or its
 * compression broken or truncated). */
int text_file_read(struct text_file *file, struct text_block *block, struct app_error *error);
/* How much of the file has been read, 0..1; 0 of what has no length, such as a pipe. */
double text_file_fraction(const struct text_file *file);
/* Was the last block the whole rest of the file? */
int text_file_ended(const struct text_file *file);

#endif
