/* arena.h: memory of the caller's, taken piece by piece.
 *
 *     tl_arena arena;
 *     tl_arena_init(&arena, memory, bytes);
 *     double *x = tl_arena_take(&arena, n * sizeof *x);   // NULL when it is used up
 *
 * Nothing is given back one by one: keep a copy of the arena and restore it.
 */
#ifndef TALUS_ARENA_H
#define TALUS_ARENA_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tl_arena {
  unsigned char *memory;
  size_t size, used;
  size_t wanted; /* bytes that were asked for in all, also beyond the size */
} tl_arena;

/* memory: `size` bytes aligned for any type. Nullable: memory when size is 0 (to measure what is wanted). */
void tl_arena_init(tl_arena *arena, void *memory, size_t size);
/* `bytes` of memory aligned for any type, not cleared; NULL when they are not there. */
void *tl_arena_take(tl_arena *arena, size_t bytes);

#ifdef __cplusplus
}
#endif
#endif
