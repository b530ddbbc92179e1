/* recording_writer.h: a recording written sample by sample, as CSV or gzip-compressed CSV.
 *
 *     struct recording_writer *writer = recording_writer_open("walk.csv.gz", channels, decimals, &error);
 *     recording_writer_row(writer, row);
 *     if (recording_writer_commit(writer, &error) != 0) return app_exit(&error);
 *
 * The file appears whole or not at all (output.h), and the same rows are the same bytes.
 */
#ifndef RECORDING_WRITER_H
#define RECORDING_WRITER_H

#include <stdint.h>

#include "common/error.h"
#include "talus/channel.h"

struct recording_writer;

/* `channels` is a set of TL_CHANNEL_BIT, the columns in the order of tl_channel; each number is
 * rounded to `decimals[channel]` places. A name that ends in ".gz" is compressed. NULL on failure;
 * ends with recording_writer_commit or recording_writer_abandon, which free it. */
struct recording_writer *recording_writer_open(const char *path, uint32_t channels,
                                               const int decimals[TL_CHANNEL_COUNT], struct app_error *error);
void recording_writer_row(struct recording_writer *writer, const double row[TL_CHANNEL_COUNT]);
/* 0, or -1 with status 1. */
int recording_writer_commit(struct recording_writer *writer, struct app_error *error);
/* Nullable: writer. */
void recording_writer_abandon(struct recording_writer *writer);

#endif
