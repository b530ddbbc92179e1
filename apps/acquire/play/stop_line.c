/* stop_line.c: opened before the start, so that an edge needs nothing but to send. */
#define _GNU_SOURCE

#include "stop_line.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "acquire/host/clocks.h"
#include "acquire/record/can_text.h"
#include "leg_bus/leg_bus.h"

enum { EMERGENCY_STOP = 1 /* the DBC's reason */, SEND_ATTEMPTS = 200, SEND_WAIT_NS = 100000 };

static int own_frames(struct can_frame frame[STOP_FRAMES]) {
  for (int i = 0; i < STOP_FRAMES; i++) {
    struct leg_bus_frame stop;
    memset(&stop, 0, sizeof stop);
    leg_bus_stop(&stop, (uint16_t)i, EMERGENCY_STOP, 0);
    memset(&frame[i], 0, sizeof frame[i]);
    frame[i].can_id = stop.id;
    frame[i].can_dlc = stop.length;
    memcpy(frame[i].data, stop.data, sizeof stop.data);
  }
  return 0;
}

static int given_frames(const char *text, struct can_frame frame[STOP_FRAMES]) {
  for (int i = 0; i < STOP_FRAMES; i++)
    if (can_text_parse(text, &frame[i]) != 0) return -1;
  return 0;
}

int stop_line_open(struct stop_line *stop, const char *text, struct app_error *error) {
  const char *frame = strchr(text, ':');
  const size_t n = frame ? (size_t)(frame - text) : strlen(text);
  char name[LINK_NAME] = "";
  if (n == 0 || n >= sizeof name ||
      (frame ? given_frames(frame + 1, stop->frame) : own_frames(stop->frame)) != 0)
    return app_fail(error, APP_BAD_INPUT,
                    "--stop: expected for instance can0 or can0:001#0011, found '%.60s'", text);
  snprintf(name, sizeof name, "%.*s", (int)n, text);
  stop->told = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  const int failure = can_port_open(&stop->port, name);
  if (failure == ENODEV) return app_fail(error, APP_BAD_INPUT, "--stop: %s: no such interface", name);
  return failure ? app_fail(error, APP_FAILED, "--stop: %s: %s", name, strerror(failure)) : 0;
}

void stop_line_close(struct stop_line *stop) {
  can_port_close(&stop->port);
  if (stop->told >= 0) close(stop->told);
  stop->told = -1;
}

/* ---- the emergency ------------------------------------------------------------------ */

/* a full transmit queue empties within a frame's time, or never */
static int send_frame(struct can_port *port, const struct can_frame *frame, int *attempts) {
  int failure = ENOBUFS;
  for (int i = 0; i < SEND_ATTEMPTS && (failure == ENOBUFS || failure == EAGAIN); i++) {
    if (i) clock_sleep_until(clock_mono_ns() + SEND_WAIT_NS);
    ++*attempts;
    failure = can_port_send(port, frame);
  }
  return failure;
}

void stop_line_send(struct stop_line *stop, struct item *item) {
  if (stop->playing) __atomic_store_n(stop->playing, 1, __ATOMIC_RELEASE);
  for (int i = 0; i < STOP_FRAMES; i++) {
    const int failure = send_frame(&stop->port, &stop->frame[i], &item->is.stop.attempts);
    if (failure) item->is.stop.failure = failure;
    item->is.stop.frames += failure == 0;
  }
  item->is.stop.mono_ns = clock_mono_ns();
  item->real_ns = clock_real_ns();
}

void stop_line_tell(const struct stop_line *stop) {
  const uint64_t one = 1;
  if (write(stop->told, &one, sizeof one) < 0) return; /* full: it is readable then */
}

int stop_line_path(const struct stop_line *stop, int netlink) {
  struct link_state link;
  if (link_query(netlink, stop->port.name, &link) != 0) return errno;
  if (!link.index || !link.is_can) return ENODEV;
  return link.up && link.bus.state != BUS_OFF ? 0 : ENETDOWN;
}
