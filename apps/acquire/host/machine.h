/* machine.h: what the system says about itself in small files. */
#ifndef MACHINE_H
#define MACHINE_H

#include <stddef.h>
#include <stdint.h>

/* The first line of a file; 0, or -1 when it cannot be read. */
int machine_line(const char *path, char *out, size_t size);
/* The number in it, or `otherwise`. */
int64_t machine_number(const char *path, int64_t otherwise);
/* Sum over the processors of /sys/devices/system/cpu/cpuN/`name`; -1 where none has it. */
int64_t machine_cpu_sum(const char *name);
/* How many processors have the file, and in how many it holds `value`. */
void machine_cpu_count(const char *name, const char *value, int *there, int *equal);

#endif
