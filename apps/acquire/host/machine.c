/* machine.c: reading sysfs. */
#define _GNU_SOURCE

#include "machine.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PROCESSORS = 1024 };

int machine_line(const char *path, char *out, size_t size) {
  FILE *file = fopen(path, "re");
  if (!file) return -1;
  const int ok = fgets(out, (int)size, file) != NULL;
  fclose(file);
  if (!ok) return -1;
  out[strcspn(out, "\n")] = '\0';
  return 0;
}

int64_t machine_number(const char *path, int64_t otherwise) {
  char line[64], *end;
  if (machine_line(path, line, sizeof line) != 0) return otherwise;
  const int64_t number = strtoll(line, &end, 10);
  return end == line ? otherwise : number;
}

static const char *cpu_path(char out[128], int cpu, const char *name) {
  snprintf(out, 128, "/sys/devices/system/cpu/cpu%d/%s", cpu, name);
  return out;
}

int64_t machine_cpu_sum(const char *name) {
  char path[128];
  int64_t sum = -1;
  for (int cpu = 0; cpu < MOST_PROCESSORS; cpu++) {
    const int64_t one = machine_number(cpu_path(path, cpu, name), -1);
    if (one >= 0) sum = (sum < 0 ? 0 : sum) + one;
  }
  return sum;
}

void machine_cpu_count(const char *name, const char *value, int *there, int *equal) {
  char path[128], line[64];
  *there = *equal = 0;
  for (int cpu = 0; cpu < MOST_PROCESSORS; cpu++) {
    if (machine_line(cpu_path(path, cpu, name), line, sizeof line) != 0) continue;
    ++*there;
    *equal += strcmp(line, value) == 0;
  }
}
