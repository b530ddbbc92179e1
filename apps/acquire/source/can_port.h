/* can_port.h: a CAN interface by its name, whatever is plugged in under it. Reader, emergency stop and player use it.
 *
 *     can_port_open(&port, "can0");
 *     can_port_send(&port, &frame);                 to whatever is called can0 now
 *     can_port_receive_all(&port); can_port_exclude(&port, other, n);
 *     can_port_close(&port);
 *
 * The socket is bound to no interface. So it outlives every unplugging, no error of an interface that went away or down
 * waits in it for the next call, and a reader has the first frame of an adapter that was plugged in just now.
 */
#ifndef CAN_PORT_H
#define CAN_PORT_H

#include <linux/can.h>

#include "link.h"

enum { CAN_PORT_EXCLUDED = 64 };

struct can_port {
  char name[LINK_NAME];
  int fd;
  int index; /* the interface that has the name, or the last one that had it */
};

/* 0, or an errno: ENODEV when nothing has the name. The socket receives nothing. */
int can_port_open(struct can_port *port, const char *name);
void can_port_close(struct can_port *port);

/* Looks the name up; the index now, or 0 (then the last one stays in `index`: it may only have another name). */
int can_port_look(struct can_port *port);
/* Is the interface of `index` still there, whatever its name is? */
int can_port_exists(const struct can_port *port);
/* One frame, without waiting; 0 or an errno. Looks the name up before. */
int can_port_send(struct can_port *port, const struct can_frame *frame);

/* From now on receives data and error frames of all interfaces but those excluded; 0 or an errno. */
int can_port_receive_all(struct can_port *port);
/* Leaves out the frames of these interfaces; 0 or an errno. */
int can_port_exclude(struct can_port *port, const int *index, int n);

#endif
