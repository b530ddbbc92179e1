/* recording_read.c: what the recording reader makes of a file, for tests/test_recording_reader.py.
 *
 *   recording_read PLANT FILE            rows, times and channels as text, one line each
 *   recording_read PLANT FILE BLOCK      and all rows, read BLOCK at a time, as raw doubles
 *                                        (channels in the order named, then valid)
 *   recording_read PLANT FILE BLOCK 1    the same, blocks from the last to the first
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "recording/recording.h"

static int print_summary(const struct recording *r) {
  fprintf(stderr, "rows %zu first_s %.17g last_s %.17g step_s %.17g channels", recording_rows(r),
          recording_first_s(r), recording_last_s(r), recording_step_s(r));
  int n = 0;
  for (int c = 0; c < TL_CHANNEL_COUNT; c++)
    if (recording_has(r, (tl_channel)c)) {
      fprintf(stderr, " %s", tl_channel_name((tl_channel)c));
      n++;
    }
  fprintf(stderr, "\n");
  return n;
}

/* rows [from, from + n), row by row: every channel that is there, then valid */
static int print_rows(struct recording *r, size_t from, size_t n, double *const column[], uint8_t *valid,
                      struct app_error *error) {
  if (recording_read(r, from, n, column, valid, error) != 0) return -1;
  for (size_t i = 0; i < n; i++) {
    for (int c = 0; c < TL_CHANNEL_COUNT; c++)
      if (recording_has(r, (tl_channel)c)) fwrite(&column[c][i], sizeof(double), 1, stdout);
    const double ok = valid[i];
    fwrite(&ok, sizeof ok, 1, stdout);
  }
  return 0;
}

static int print_all(struct recording *r, size_t block, int backwards, struct app_error *error) {
  const size_t rows = recording_rows(r), blocks = (rows + block - 1) / block;
  double *memory = malloc(block * TL_CHANNEL_COUNT * sizeof *memory), *column[TL_CHANNEL_COUNT];
  uint8_t *valid = malloc(block);
  int result = memory && valid ? 0 : app_fail(error, APP_FAILED, "out of memory");
  for (size_t c = 0; c < TL_CHANNEL_COUNT && result == 0; c++) column[c] = memory + c * block;
  for (size_t b = 0; b < blocks && result == 0; b++) {
    const size_t from = (backwards ? blocks - 1 - b : b) * block;
    result = print_rows(r, from, rows - from < block ? rows - from : block, column, valid, error);
  }
  free(memory);
  free(valid);
  return result;
}

int main(int argc, char **argv) {
  struct app_error error;
  tl_plant plant;
  app_set_name("recording_read");
  if (argc < 3 || tl_plant_find(argv[1], &plant) != TL_OK) return APP_BAD_INPUT;
  struct recording *r = recording_open(argv[2], plant, &error);
  if (!r) return app_exit(&error);
  int result = 0;
  print_summary(r);
  if (argc > 3) result = print_all(r, (size_t)strtoul(argv[3], NULL, 10), argc > 4, &error);
  recording_close(r);
  return result == 0 ? APP_OK : app_exit(&error);
}
