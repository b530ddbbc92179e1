/* read_recording.c: how long the programs' reader takes for a recording, for tools/bench/reading.py.
 *
 *   read_recording PLANT FILE
 *
 * Parses and checks the whole file and then reads every row of every channel, block by
 * block, as the programs do. Prints JSON: rows, seconds on the clock and on the processors,
 * and the sum of each column.
 */
#define BLOCK_ROWS 4096

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "recording/recording.h"

static double seconds(clockid_t clock) {
  struct timespec now = {0, 0};
  clock_gettime(clock, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* sum[channel] over all rows; 0 or -1 */
static int add_rows(struct recording *r, double sum[TL_CHANNEL_COUNT], struct app_error *error) {
  static double memory[TL_CHANNEL_COUNT][BLOCK_ROWS];
  double *column[TL_CHANNEL_COUNT];
  const size_t rows = recording_rows(r);
  for (int c = 0; c < TL_CHANNEL_COUNT; c++) column[c] = recording_has(r, (tl_channel)c) ? memory[c] : NULL;
  for (size_t from = 0; from < rows; from += BLOCK_ROWS) {
    const size_t n = rows - from < BLOCK_ROWS ? rows - from : BLOCK_ROWS;
    if (recording_read(r, from, n, column, NULL, error) != 0) return -1;
    for (int c = 0; c < TL_CHANNEL_COUNT; c++)
      for (size_t i = 0; column[c] && i < n; i++) sum[c] += column[c][i];
  }
  return 0;
}

static void print(const struct recording *r, const double sum[TL_CHANNEL_COUNT], double wall_s,
                  double cpu_s) {
  printf("{\"rows\": %zu, \"wall_s\": %.9f, \"cpu_s\": %.9f, \"sum\": {", recording_rows(r), wall_s, cpu_s);
  const char *comma = "";
  for (int c = 0; c < TL_CHANNEL_COUNT; c++) {
    if (!recording_has(r, (tl_channel)c)) continue;
    printf("%s\"%s\": %.17g", comma, tl_channel_name((tl_channel)c), sum[c]);
    comma = ", ";
  }
  printf("}}\n");
}

int main(int argc, char **argv) {
  struct app_error error;
  tl_plant plant;
  app_set_name("read_recording");
  if (argc != 3 || tl_plant_find(argv[1], &plant) != TL_OK) {
    fprintf(stderr, "usage: read_recording PLANT FILE\n");
    return APP_BAD_INPUT;
  }
  double sum[TL_CHANNEL_COUNT] = {0.0};
  const double wall_s = seconds(CLOCK_MONOTONIC), cpu_s = seconds(CLOCK_PROCESS_CPUTIME_ID);
  struct recording *r = recording_open(argv[2], plant, &error);
  if (!r) return app_exit(&error);
  const int result = add_rows(r, sum, &error);
  if (result == 0)
    print(r, sum, seconds(CLOCK_MONOTONIC) - wall_s, seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_s);
  recording_close(r);
  return result == 0 ? APP_OK : app_exit(&error);
}
