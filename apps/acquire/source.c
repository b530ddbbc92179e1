/* source.c: what all sources share. */
#define _GNU_SOURCE

#include "source.h"

#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "clocks.h"

enum {
  CAN_RING = 1 << 16,
  GPIO_RING = 1 << 12,
  WAIT_NS = 500000,
  SEND_ATTEMPTS = 200,
  SEND_WAIT_NS = 100000
};

static const struct source_face *const faces[] = {[SOURCE_CAN] = &source_can,
                                                  [SOURCE_GPIO] = &source_gpio,
                                                  [SOURCE_ESTOP] = &source_gpio,
                                                  [SOURCE_PULSE] = &source_pulse,
                                                  [SOURCE_FD] = &source_fd};

int source_open(struct source *source, const struct source_spec *spec, uint8_t index,
                const struct source_settings *settings, struct app_error *error) {
  const int can = spec->kind == SOURCE_CAN || spec->kind == SOURCE_FD;
  memset(source, 0, sizeof *source);
  source->spec = *spec;
  source->settings = settings;
  source->face = faces[spec->kind];
  source->index = index;
  source->fd = -1;
  if (ring_init(&source->ring, can ? CAN_RING : GPIO_RING) != 0)
    return app_fail(error, APP_FAILED, "out of memory");
  return source->face->open(source, error);
}

void source_close(struct source *source) {
  if (source->face) source->face->close(source);
  ring_free(&source->ring);
}

static void wait_ns(long ns) {
  const struct timespec t = {0, ns};
  nanosleep(&t, NULL);
}

void source_push(struct source *source, const struct item *item) {
  while (!ring_push(&source->ring, item)) {
    if (__atomic_load_n(&source->writer_dead, __ATOMIC_RELAXED)) {
      source->abandoned += item->kind == ITEM_FRAME || item->kind == ITEM_EDGE;
      return;
    }
    wait_ns(WAIT_NS);
  }
}

/* a full transmit queue empties within a frame's time, or never */
static int send_frame(int fd, const struct can_frame *frame, int64_t *attempts) {
  for (int i = 0; i < SEND_ATTEMPTS; i++) {
    ++*attempts;
    if (send(fd, frame, sizeof *frame, MSG_DONTWAIT) == (ssize_t)sizeof *frame) return 0;
    if (errno != ENOBUFS && errno != EAGAIN) return errno;
    wait_ns(SEND_WAIT_NS);
  }
  return ENOBUFS;
}

void source_send_stop(struct source *source, const struct stop_line *stop) {
  struct item item = {.kind = ITEM_STOP, .source = source->index};
  int failure = 0;
  if (stop->playing) __atomic_store_n(stop->playing, 1, __ATOMIC_RELEASE);
  for (int i = 0; i < STOP_FRAMES; i++) {
    const int result = send_frame(stop->fd, &stop->frame[i], &item.is.number[2]);
    if (result) failure = result;
  }
  item.is.number[0] = clock_mono_ns();
  item.is.number[1] = failure;
  item.real_ns = clock_real_ns();
  source_push(source, &item);
}
