/* can_socket.c: see can_socket.h. */
#include "can_socket.h"

#include <errno.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define MOST_FILTERS 8
#define MOST_SKIPPED                                                                                         \
  1000 /* frames of other kinds at one go, so that a flooded bus does not hold the twin up */

static int fail(const char *interface, struct app_error *error) {
  return app_fail(error, APP_FAILED, "--can: %.40s cannot be opened: %s", interface, strerror(errno));
}

int can_socket_open(const char *interface, struct app_error *error) {
  struct sockaddr_can address = {.can_family = AF_CAN};
  const unsigned index = if_nametoindex(interface);
  int fd;

  if (index == 0)
    return app_fail(error, APP_BAD_INPUT, "--can: there is no interface '%.40s' (`ip link` lists them)",
                    interface);
  fd = socket(AF_CAN, SOCK_RAW, CAN_RAW);
  if (fd < 0 && errno == EAFNOSUPPORT)
    return app_fail(error, APP_FAILED, "--can: this kernel has no CAN (its module is can_raw)");
  if (fd < 0) return fail(interface, error);
  address.can_ifindex = (int)index;
  if (bind(fd, (const struct sockaddr *)&address, sizeof address) == 0) return fd;
  if (errno == ENODEV)
    app_fail(error, APP_BAD_INPUT, "--can: '%.40s' is no CAN interface", interface);
  else
    fail(interface, error);
  close(fd);
  return -1;
}

void can_socket_close(int fd) {
  close(fd);
}

int can_socket_only(int fd, const uint32_t *id, int n) {
  struct can_filter filter[MOST_FILTERS];

  if (n > MOST_FILTERS) return -1;
  for (int i = 0; i < n; i++)
    filter[i] = (struct can_filter){id[i], CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG};
  return setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, filter, (socklen_t)((size_t)n * sizeof *filter));
}

int can_socket_send(int fd, const struct leg_bus_frame *frame) {
  struct can_frame out = {.can_id = frame->id, .can_dlc = frame->length};

  memcpy(out.data, frame->data, sizeof out.data);
  return send(fd, &out, sizeof out, MSG_DONTWAIT) == (ssize_t)sizeof out ? 0 : -1;
}

int can_socket_receive(int fd, struct leg_bus_frame *frame) {
  struct can_frame in;

  for (int i = 0; i < MOST_SKIPPED; i++) {
    if (recv(fd, &in, sizeof in, MSG_DONTWAIT) != (ssize_t)sizeof in) return 0;
    if (in.can_id & (CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_ERR_FLAG)) continue;
    frame->id = in.can_id;
    frame->length = in.can_dlc;
    memcpy(frame->data, in.data, sizeof frame->data);
    return 1;
  }
  return 0;
}
