/* can_socket.h: frames to and from a SocketCAN interface, without waiting. */
#ifndef CAN_SOCKET_H
#define CAN_SOCKET_H

#include "common/error.h"
#include "leg_bus.h"

/* The socket, or -1 with status 2 when there is no such interface and 1 for any other failure. */
int can_socket_open(const char *interface, struct app_error *error);
void can_socket_close(int fd);
/* Only frames with these n identifiers come from now on: what is not read needs no room. 0, or -1 with errno. */
int can_socket_only(int fd, const uint32_t *id, int n);
/* 0, or -1 when the kernel did not take the frame. */
int can_socket_send(int fd, const struct leg_bus_frame *frame);
/* 1 and a data frame with an identifier of 11 bits, or 0 when there is none left. */
int can_socket_receive(int fd, struct leg_bus_frame *frame);

#endif
