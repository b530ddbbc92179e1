/* stop_line.c: opened before the start, so that an edge needs nothing but a send. */
#define _GNU_SOURCE

#include "stop_line.h"

#include <errno.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "can_text.h"
#include "leg_bus/leg_bus.h"

enum { EMERGENCY_STOP = 1 }; /* the DBC's reason */

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

static int open_socket(const char *name, struct app_error *error) {
  const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(name)};
  if (!address.can_ifindex) return app_fail(error, APP_BAD_INPUT, "--stop: %s: no such interface", name);
  const int fd = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
  if (fd < 0) return app_fail(error, APP_FAILED, "--stop: %s: %s", name, strerror(errno));
  setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, NULL, 0); /* it only sends */
  if (bind(fd, (const struct sockaddr *)&address, sizeof address) == 0) return fd;
  close(fd);
  return app_fail(error, APP_FAILED, "--stop: %s cannot be opened: %s", name, strerror(errno));
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
  stop->fd = open_socket(name, error);
  return stop->fd < 0 ? -1 : 0;
}
