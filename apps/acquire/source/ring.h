/* ring.h: from one thread to one other, without locks. All memory is had when it is made.
 *
 *     ring_push(&ring, &item);                  the reader; 0 when full
 *     const struct item *next = ring_peek(&ring, 0);  the writer
 *     ring_drop(&ring, 1);
 *
 * Why this needs no lock: `head` is written by the reader alone and `tail` by the writer alone, and both only rise (as
 * whole numbers; in 32 bits their difference is right as long as it is at most `size`). The reader fills item[head] only
 * when head - tail < size, with a tail that may be old, thus too low: it may find the ring full when it is not, never the
 * reverse. So it never fills a place that the writer has not dropped, and dropping (release) comes before it sees the
 * tail (acquire). The writer reads item[i] only for tail <= i < head, with a head that may be old, thus too low: it
 * may see less than there is, never more; filling the item comes before head's release, which it acquires. Every item
 * is therefore filled whole before it is read, and read before it is filled again, in any interleaving. The watermark's
 * release comes after the filling likewise: who acquires it first, then asks how much there is, sees all it promises.
 *
 * tests/test_acquire_ring.py goes through every execution of a ring of two places under C's memory model, with this code,
 * and shows that none of the six orders in ring.c may be weaker.
 */
#ifndef RING_H
#define RING_H

#include <stdint.h>

#include "item.h"

struct ring {
  struct item *item;
  uint32_t size; /* a power of two */
  uint32_t most; /* the writer's: highest filling seen */
  char apart_1[64];
  uint32_t head;        /* the reader's: items ever put in */
  int64_t watermark_ns; /* whatever is stamped before this has been put in */
  char apart_2[64];
  uint32_t tail; /* the writer's: items ever taken out */
};

/* 0, or -1 without memory. `size` is a power of two. Every page is touched. */
int ring_init(struct ring *ring, uint32_t size);
void ring_free(struct ring *ring);

uint32_t ring_room(const struct ring *ring);
int ring_push(struct ring *ring, const struct item *item);
void ring_set_watermark(struct ring *ring, int64_t real_ns);

uint32_t ring_filled(const struct ring *ring);
/* The i-th oldest, i < ring_filled; stays until it is dropped. */
const struct item *ring_peek(const struct ring *ring, uint32_t i);
void ring_drop(struct ring *ring, uint32_t n);
int64_t ring_watermark(const struct ring *ring);

#endif
