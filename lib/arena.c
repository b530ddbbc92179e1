/* arena.c: see talus/arena.h. */
#include "talus/arena.h"

#define ALIGN 16

void tl_arena_init(tl_arena *arena, void *memory, size_t size) {
  arena->memory = memory;
  arena->size = size;
  arena->used = arena->wanted = 0;
}

void *tl_arena_take(tl_arena *arena, size_t bytes) {
  size_t rounded = (bytes + ALIGN - 1) / ALIGN * ALIGN, at = arena->used;

  if (rounded < bytes) return NULL;
  arena->wanted += rounded;
  if (rounded > arena->size - at) return NULL;
  arena->used += rounded;
  return arena->memory + at;
}
