/* random_inline.h: the generator for hot loops, private to the library. */
#ifndef TALUS_RANDOM_INLINE_H
#define TALUS_RANDOM_INLINE_H

#include <stdint.h>

/* Multipliers and Weyl increments of Philox4x32 (Salmon et al. 2011, sec. 3.3). */
#define TL_PHILOX_M0 0xD2511F53u
#define TL_PHILOX_M1 0xCD9E8D57u
#define TL_PHILOX_W0 0x9E3779B9u
#define TL_PHILOX_W1 0xBB67AE85u
#define TL_PHILOX_ROUNDS 10

static inline void tl_philox_inline(const uint32_t counter[4], const uint32_t key[2], uint32_t out[4]) {
  uint32_t c0 = counter[0], c1 = counter[1], c2 = counter[2], c3 = counter[3];
  uint32_t k0 = key[0], k1 = key[1];
  for (int round = 0; round < TL_PHILOX_ROUNDS; round++) {
    uint64_t p0 = (uint64_t)TL_PHILOX_M0 * c0;
    uint64_t p1 = (uint64_t)TL_PHILOX_M1 * c2;
    c0 = (uint32_t)(p1 >> 32) ^ c1 ^ k0;
    c1 = (uint32_t)p1;
    c2 = (uint32_t)(p0 >> 32) ^ c3 ^ k1;
    c3 = (uint32_t)p0;
    k0 += TL_PHILOX_W0;
    k1 += TL_PHILOX_W1;
  }
  out[0] = c0;
  out[1] = c1;
  out[2] = c2;
  out[3] = c3;
}

/* 64 random bits to [0, 1): the upper 53 of them, exactly. */
static inline double tl_uniform_of_words(uint32_t low, uint32_t high) {
  uint64_t bits = ((uint64_t)high << 32) | low;
  return (double)(int64_t)(bits >> 11) * 0x1p-53;
}

static inline void tl_random_uniform2_inline(uint64_t seed, uint64_t stream, uint64_t counter,
                                             double out[2]) {
  uint32_t words[4] = {(uint32_t)counter, (uint32_t)(counter >> 32), (uint32_t)stream,
                       (uint32_t)(stream >> 32)};
  uint32_t key[2] = {(uint32_t)seed, (uint32_t)(seed >> 32)};
  tl_philox_inline(words, key, words);
  out[0] = tl_uniform_of_words(words[0], words[1]);
  out[1] = tl_uniform_of_words(words[2], words[3]);
}

#endif
