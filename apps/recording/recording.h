/* recording.h: a recording, read once and then available at any row.
 *
 *     struct recording *recording = recording_open(path, TL_PLANT_LEG, &error);
 *     if (!recording) return app_exit(&error);
 *     double *column[TL_CHANNEL_COUNT] = {NULL};
 *     column[TL_CHANNEL_TIME] = t_s;
 *     recording_read(recording, 0, n, column, valid, &error);
 *     recording_close(recording);
 *
 * Opening parses and checks the whole file, CSV or gzip-compressed CSV, and keeps
 * the columns that the plant knows in a temporary file (spool.h): memory is the
 * same for a minute and for an hour.
 *
 * The format. A header line with the columns' names in any order, then one line a
 * sample; comma separated, '.' decimal. Lines that begin with '#' are comments.
 * Blanks around a field, a byte order mark, \r\n and blank lines before the header
 * or at the end are accepted. Columns that the plant does not know are not
 * read; they are named once, in one line on standard error.
 */
#ifndef RECORDING_H
#define RECORDING_H

#include <stddef.h>
#include <stdint.h>

#include "common/error.h"
#include "talus/plant.h"

#define RECORDING_MIN_ROWS 100

struct recording;

/* NULL on failure, with status 2 and a text that names file, line or column when the
 * file is at fault: a missing or double column, a field that is empty or no finite
 * number, too few or too many fields, `valid` other than 0 or 1, time that does not
 * rise, fewer than RECORDING_MIN_ROWS samples, an empty, truncated or unreadable
 * file. `path` must outlive the recording, which the caller closes. */
struct recording *recording_open(const char *path, tl_plant plant, struct app_error *error);
/* Every `every`-th sample of TL_READING_PLACES places of a recording (tl_reading_place), each place_rows long (a multiple of
 * `every`), from their first on, as a recording of its own; of the whole one where that is shorter. NULL where fewer than
 * RECORDING_MIN_ROWS would be left, or on failure. The whole one must outlive it, and the two are not read at the same
 * time. */
struct recording *recording_excerpt(const struct recording *whole, size_t place_rows, size_t every,
                                    struct app_error *error);
/* Nullable: recording. */
void recording_close(struct recording *recording);

const char *recording_path(const struct recording *recording);
size_t recording_rows(const struct recording *recording);
/* Is there a column for this channel? */
int recording_has(const struct recording *recording, tl_channel channel);
/* Times of the first and the last sample, and the median step [s]: exact up to 131,072
 * steps, beyond that of an even sample of them (step_median.h). */
double recording_first_s(const struct recording *recording);
double recording_last_s(const struct recording *recording);
double recording_step_s(const struct recording *recording);

/* Rows [from, from + n) into the caller's arrays of n: column[channel] where it is
 * not NULL and the recording has the channel, and valid[] (all 1 without that
 * column). 0, or -1 when the temporary file cannot be read. Several threads may read at once.
 * Nullable: valid and the members of column. */
int recording_read(struct recording *recording, size_t from, size_t n, double *const column[TL_CHANNEL_COUNT],
                   uint8_t *valid, struct app_error *error);

#endif
