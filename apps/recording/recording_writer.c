/* recording_writer.c: see recording_writer.h. */
#include "recording_writer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "common/number.h"
#include "common/output.h"

#define CHUNK 65536
#define GZIP_WINDOW (15 + 16) /* zlib's way to ask for a gzip header; its time stays 0 */

struct recording_writer {
  struct output *out;
  uint32_t channels;
  double scale[TL_CHANNEL_COUNT]; /* 10^decimals */
  int compressed;
  int broken; /* compression failed: out of memory */
  z_stream zip;
  size_t held; /* bytes of text that wait */
  char text[CHUNK];
  unsigned char packed[CHUNK];
};

/* passes on what waits; `flush` is zlib's */
static void pass_on(struct recording_writer *w, int flush) {
  if (!w->compressed) {
    output_bytes(w->out, w->text, w->held);
    w->held = 0;
    return;
  }
  w->zip.next_in = (unsigned char *)w->text;
  w->zip.avail_in = (uInt)w->held;
  do {
    w->zip.next_out = w->packed;
    w->zip.avail_out = CHUNK;
    if (deflate(&w->zip, flush) == Z_STREAM_ERROR) w->broken = 1;
    output_bytes(w->out, w->packed, CHUNK - w->zip.avail_out);
  } while (w->zip.avail_out == 0 && !w->broken);
  w->held = 0;
}

/* adds text of at most NUMBER_TEXT or a column name's length, and a separator */
static void add(struct recording_writer *w, const char *text, size_t n, char separator) {
  if (w->held + n + 1 > CHUNK) pass_on(w, Z_NO_FLUSH);
  memcpy(w->text + w->held, text, n);
  w->held += n;
  w->text[w->held++] = separator;
}

static char separator_after(const struct recording_writer *w, int channel) {
  return w->channels >> channel > 1 ? ',' : '\n';
}

struct recording_writer *recording_writer_open(const char *path, uint32_t channels,
                                               const int decimals[TL_CHANNEL_COUNT],
                                               struct app_error *error) {
  struct recording_writer *w = calloc(1, sizeof *w);
  size_t length = strlen(path);

  if (!w) {
    app_fail(error, APP_FAILED, "out of memory");
    return NULL;
  }
  w->channels = channels;
  w->compressed = length > 3 && strcmp(path + length - 3, ".gz") == 0;
  if (w->compressed && deflateInit2(&w->zip, 6, Z_DEFLATED, GZIP_WINDOW, 8, Z_DEFAULT_STRATEGY) != Z_OK) {
    app_fail(error, APP_FAILED, "%s: out of memory", path);
    free(w);
    return NULL;
  }
  w->out = output_open(path, error);
  if (!w->out) {
    if (w->compressed) deflateEnd(&w->zip);
    free(w);
    return NULL;
  }
  for (int c = 0; c < TL_CHANNEL_COUNT; c++) {
    w->scale[c] = pow(10.0, decimals[c]);
    if (!(channels & TL_CHANNEL_BIT(c))) continue;
    const char *name = tl_channel_name((tl_channel)c);
    add(w, name, strlen(name), separator_after(w, c));
  }
  return w;
}

void recording_writer_row(struct recording_writer *writer, const double row[TL_CHANNEL_COUNT]) {
  char text[NUMBER_TEXT];

  for (int c = 0; c < TL_CHANNEL_COUNT; c++) {
    if (!(writer->channels & TL_CHANNEL_BIT(c))) continue;
    double rounded = nearbyint(row[c] * writer->scale[c]) / writer->scale[c];
    add(writer, text, number_rounded(text, rounded == 0.0 ? 0.0 : rounded), separator_after(writer, c));
  }
}

static void release(struct recording_writer *w) {
  if (w->compressed) deflateEnd(&w->zip);
  free(w);
}

int recording_writer_commit(struct recording_writer *writer, struct app_error *error) {
  int result;

  pass_on(writer, Z_FINISH);
  if (writer->broken) {
    recording_writer_abandon(writer);
    return app_fail(error, APP_FAILED, "compression failed");
  }
  result = output_commit(writer->out, error);
  release(writer);
  return result;
}

void recording_writer_abandon(struct recording_writer *writer) {
  if (!writer) return;
  output_abandon(writer->out);
  release(writer);
}
