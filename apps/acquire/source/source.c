/* source.c: what all sources share. */
#define _GNU_SOURCE

#include "source.h"

#include <string.h>

#include "acquire/host/clocks.h"

enum { CAN_RING = 1 << 16, GPIO_RING = 1 << 12, WAIT_NS = 500000 };

static const struct source_ops *const kinds[] = {[SOURCE_CAN] = &source_can,
                                                 [SOURCE_GPIO] = &source_gpio,
                                                 [SOURCE_ESTOP] = &source_gpio,
                                                 [SOURCE_PULSE] = &source_pulse,
                                                 [SOURCE_FD] = &source_fd};

int source_is_can(const struct source *source) {
  return source->spec.kind == SOURCE_CAN || source->spec.kind == SOURCE_FD;
}

int source_open(struct source *source, const struct source_spec *spec, uint8_t index,
                const struct source_settings *settings, struct app_error *error) {
  memset(source, 0, sizeof *source);
  source->spec = *spec;
  source->settings = settings;
  source->ops = kinds[spec->kind];
  source->index = index;
  source->fd = source->events = source->port.fd = -1;
  source->pressed = -1;
  if (ring_init(&source->ring, source_is_can(source) ? CAN_RING : GPIO_RING) != 0)
    return app_fail(error, APP_FAILED, "out of memory");
  return source->ops->open(source, error);
}

void source_close(struct source *source) {
  if (source->ops) source->ops->close(source);
  ring_free(&source->ring);
}

void source_add(uint64_t *count, uint64_t more) {
  __atomic_store_n(count, __atomic_load_n(count, __ATOMIC_RELAXED) + more, __ATOMIC_RELAXED);
}

uint64_t source_count(const uint64_t *count) {
  return __atomic_load_n(count, __ATOMIC_RELAXED);
}

int source_wait_for_room(const struct source *source) {
  if (__atomic_load_n(&source->writer_dead, __ATOMIC_ACQUIRE)) return 0;
  clock_sleep_until(clock_mono_ns() + WAIT_NS);
  return 1;
}

void source_push(struct source *source, const struct item *item) {
  while (!ring_push(&source->ring, item)) {
    if (source_wait_for_room(source)) continue;
    source_add(ITEM_IS_COUNTED(item->kind) ? &source->count.abandoned : &source->count.events_abandoned, 1);
    return;
  }
}
