/* ring.h: from one thread to one other, without locks. All memory is had when it is made.
 *
 *     ring_push(&ring, &item);                  the reader; 0 when full
 *     const struct item *next = ring_peek(&ring, 0);  the writer
 *     ring_drop(&ring, 1);
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
