/* spool.h: rows of doubles in a temporary file that has no name.
 *
 * What does not fit into memory waits here, to be read at any row. The file is
 * unlinked as soon as it is open, so nothing stays behind, whatever happens to the
 * program. It lies in $TMPDIR, or else in /var/tmp, or else in /tmp.
 */
#ifndef SPOOL_H
#define SPOOL_H

#include <stddef.h>

#include "common/error.h"

struct spool;

/* NULL on failure. `width` doubles a row, 1..64. Owned by the caller. */
struct spool *spool_open(size_t width, struct app_error *error);
/* Nullable: spool. */
void spool_close(struct spool *spool);

/* n rows become rows [at, at + n). Different threads may write different rows. */
int spool_write(const struct spool *spool, size_t at, const double *row, size_t n, struct app_error *error);

/* At most n rows from row `from` on, as they were written: *rows of them (fewer
 * than n where the buffer ends), at *row, until the next call. One thread at a time,
 * after the last write. */
int spool_read(struct spool *spool, size_t from, size_t n, const double **row, size_t *rows,
               struct app_error *error);

#endif
