/* allocations.h: how often this program, or a library in it, has asked for memory. */
#ifndef ALLOCATIONS_H
#define ALLOCATIONS_H

#include <stdint.h>

/* Calls of malloc and its like so far, or -1 where they cannot be counted (another C library than
 * glibc, a build under sanitizers). */
int64_t allocations(void);

#endif
