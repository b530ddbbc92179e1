/* random.h: random numbers that depend on (seed, stream, counter) alone.
 *
 * Philox4x32-10 (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy
 * as 1, 2, 3", SC 2011): no state, so any thread may draw any number in any
 * order and the numbers are always the same.
 *
 *     double first[2], again[2];
 *     tl_random_normal2(1, 7, 1000, first); // seed 1, stream 7, draw 1000
 *     tl_random_normal2(1, 7, 1000, again);
 *     if (first[0] != again[0] || first[1] != again[1]) return 1;
 */
#ifndef TALUS_RANDOM_H
#define TALUS_RANDOM_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The raw generator: 10 rounds over counter[4] under key[2] into out[4]. */
void tl_philox4x32(const uint32_t counter[4], const uint32_t key[2], uint32_t out[4]);

/* Two numbers uniform in [0, 1), each with 53 random bits. `stream` names what
 * they are for, `counter` which draw it is. */
void tl_random_uniform2(uint64_t seed, uint64_t stream, uint64_t counter, double out[2]);

/* Two independent standard normal numbers (Box and Muller 1958). */
void tl_random_normal2(uint64_t seed, uint64_t stream, uint64_t counter, double out[2]);

#ifdef __cplusplus
}
#endif
#endif
