/* ring.c: single producer, single consumer. */
#include "ring.h"

#include <stdlib.h>
#include <string.h>

int ring_init(struct ring *ring, uint32_t size) {
  memset(ring, 0, sizeof *ring);
  ring->item = malloc(size * sizeof *ring->item);
  if (!ring->item) return -1;
  memset(ring->item, 0, size * sizeof *ring->item);
  ring->size = size;
  return 0;
}

void ring_free(struct ring *ring) {
  free(ring->item);
  ring->item = NULL;
}

/* ---- the one who puts in ------------------------------------------------------ */

uint32_t ring_room(const struct ring *ring) {
  return ring->size - (ring->head - __atomic_load_n(&ring->tail, __ATOMIC_ACQUIRE));
}

int ring_push(struct ring *ring, const struct item *item) {
  if (ring_room(ring) == 0) return 0;
  ring->item[ring->head & (ring->size - 1)] = *item;
  __atomic_store_n(&ring->head, ring->head + 1, __ATOMIC_RELEASE);
  return 1;
}

void ring_set_watermark(struct ring *ring, int64_t real_ns) {
  __atomic_store_n(&ring->watermark_ns, real_ns, __ATOMIC_RELEASE);
}

/* ---- the one who takes out ------------------------------------------------------ */

uint32_t ring_filled(const struct ring *ring) {
  return __atomic_load_n(&ring->head, __ATOMIC_ACQUIRE) - ring->tail;
}

const struct item *ring_peek(const struct ring *ring, uint32_t i) {
  return &ring->item[(ring->tail + i) & (ring->size - 1)];
}

void ring_drop(struct ring *ring, uint32_t n) {
  __atomic_store_n(&ring->tail, ring->tail + n, __ATOMIC_RELEASE);
}

int64_t ring_watermark(const struct ring *ring) {
  return __atomic_load_n(&ring->watermark_ns, __ATOMIC_ACQUIRE);
}
