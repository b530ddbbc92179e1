/* can_port.c: one raw socket for good. */
#define _GNU_SOURCE

#include "can_port.h"

#include <errno.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/filter.h>
#include <net/if.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

int can_port_look(struct can_port *port) {
  struct ifreq ask;
  memset(&ask, 0, sizeof ask);
  memcpy(ask.ifr_name, port->name, sizeof port->name);
  if (ioctl(port->fd, SIOCGIFINDEX, &ask) != 0) return 0;
  __atomic_store_n(&port->index, ask.ifr_ifindex, __ATOMIC_RELAXED); /* several buttons may share a port */
  return ask.ifr_ifindex;
}

int can_port_exists(const struct can_port *port) {
  struct ifreq ask;
  memset(&ask, 0, sizeof ask);
  ask.ifr_ifindex = port->index;
  return ioctl(port->fd, SIOCGIFNAME, &ask) == 0 || errno != ENODEV;
}

int can_port_open(struct can_port *port, const char *name) {
  memset(port, 0, sizeof *port);
  memcpy(port->name, name, strnlen(name, sizeof port->name - 1));
  port->fd = -1;
  if (!if_nametoindex(port->name)) return ENODEV;
  port->fd = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
  if (port->fd < 0) return errno;
  setsockopt(port->fd, SOL_CAN_RAW, CAN_RAW_FILTER, NULL, 0);
  if (can_port_look(port)) return 0;
  can_port_close(port);
  return ENODEV;
}

void can_port_close(struct can_port *port) {
  if (port->fd >= 0) close(port->fd);
  port->fd = -1;
}

/* ---- sending ------------------------------------------------------------------- */

int can_port_send(struct can_port *port, const struct can_frame *frame) {
  struct sockaddr_can to = {.can_family = AF_CAN};
  const int now = can_port_look(port);
  to.can_ifindex = now ? now : __atomic_load_n(&port->index, __ATOMIC_RELAXED);
  const ssize_t n =
      sendto(port->fd, frame, sizeof *frame, MSG_DONTWAIT, (const struct sockaddr *)&to, sizeof to);
  return n == (ssize_t)sizeof *frame ? 0 : errno;
}

/* ---- receiving ------------------------------------------------------------------- */

int can_port_receive_all(struct can_port *port) {
  const struct sockaddr_can all = {.can_family = AF_CAN};
  const struct can_filter every = {0, 0};
  const can_err_mask_t errors = CAN_ERR_MASK;
  if (setsockopt(port->fd, SOL_CAN_RAW, CAN_RAW_FILTER, &every, sizeof every) != 0 ||
      setsockopt(port->fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) != 0 ||
      bind(port->fd, (const struct sockaddr *)&all, sizeof all) != 0)
    return errno;
  return 0;
}

/* load the interface's index; equal to one of them: nothing of the frame; else all of it */
int can_port_exclude(struct can_port *port, const int *index, int n) {
  struct sock_filter step[CAN_PORT_EXCLUDED + 3];
  struct sock_fprog program = {.filter = step};
  int k = 0;
  if (n > CAN_PORT_EXCLUDED) n = CAN_PORT_EXCLUDED;
  step[k++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS, (uint32_t)(SKF_AD_OFF + SKF_AD_IFINDEX));
  for (int i = 0; i < n; i++)
    step[k++] =
        (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (uint32_t)index[i], (uint8_t)(n - i), 0);
  step[k++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, UINT32_MAX);
  step[k++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, 0);
  program.len = (unsigned short)k;
  return setsockopt(port->fd, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) == 0 ? 0 : errno;
}
