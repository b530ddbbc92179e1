/* series.c: names and limits. */
#include "series.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const struct {
  const char *name;
  double bytes, ns;
} unit[] = {{"k", 1e3, 0}, {"M", 1e6, 0}, {"G", 1e9, 0}, {"s", 0, 1e9}, {"min", 0, 60e9}, {"h", 0, 3600e9}};

enum { LEAST_BYTES = 4000, LEAST_NS = 1000000000 };

int series_limit_parse(const char *text, struct series_limit *limit) {
  char *end;
  const double number = strtod(text, &end);
  for (size_t i = 0; i < sizeof unit / sizeof unit[0]; i++) {
    if (strcmp(end, unit[i].name) != 0) continue;
    const double bytes = number * unit[i].bytes, ns = number * unit[i].ns;
    if (!(bytes >= LEAST_BYTES || ns >= LEAST_NS) || bytes > 1e15 || ns > 1e18) return -1;
    *limit = (struct series_limit){llround(bytes), llround(ns)};
    return 0;
  }
  return -1;
}

static size_t ends_with(const char *text, size_t n, const char *end) {
  const size_t m = strlen(end);
  return n > m && memcmp(text + n - m, end, m) == 0 ? m : 0;
}

void series_path(char *path, size_t size, const char *log, int number) {
  size_t n = strlen(log);
  if (number == 0) {
    snprintf(path, size, "%s", log);
    return;
  }
  n -= ends_with(log, n, ".gz");
  n -= ends_with(log, n, ".log");
  snprintf(path, size, "%.*s.%03d.log", (int)n, log, number);
}

int series_find(char *path, size_t size, const char *log, int number) {
  series_path(path, size, log, number);
  if (access(path, F_OK) == 0) return 0;
  const size_t n = strlen(path);
  snprintf(path + n, size - n, ".gz");
  if (access(path, F_OK) == 0) return 0;
  path[n] = '\0';
  return number == 0 ? 0 : -1;
}
