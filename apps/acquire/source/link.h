/* link.h: what the kernel says about a network interface, through rtnetlink. */
#ifndef LINK_H
#define LINK_H

#include <stddef.h>
#include <stdint.h>

#include "bus_state.h"

enum { LINK_NAME = 16 }; /* with its end, as IFNAMSIZ */

enum link_counter {
  LINK_RX_PACKETS,
  LINK_RX_ERRORS,
  LINK_RX_DROPPED,
  LINK_RX_OVER,
  LINK_RX_FIFO,
  LINK_RX_MISSED,
  LINK_TX_PACKETS,
  LINK_TX_DROPPED,
  LINK_COUNTERS
};

/* RENAMED: it is recorded on under its old name. REPLACED: another has that name now, and is recorded instead. */
enum link_change { LINK_DOWN, LINK_UP, LINK_GONE, LINK_BACK, LINK_RENAMED, LINK_REPLACED };

struct link_state {
  int index; /* 0: there is none of that name */
  char name[LINK_NAME];
  int is_can; /* of the type CAN at all */
  int up;
  int mtu;
  char driver[LINK_NAME]; /* "can", "vcan", ... as the kernel calls the kind; may be empty */
  struct bus bus;         /* BUS_UNKNOWN where the driver has no controller, as vcan */
  uint32_t bitrate, data_bitrate, restart_ms;
  uint64_t counter[LINK_COUNTERS];
};

const char *link_counter_name(enum link_counter counter);
const char *link_change_name(enum link_change change);

/* Frames that a counter's rise tells to be lost on the way to the socket. */
int link_counter_is_loss(enum link_counter counter);

/* A netlink socket for link_query; with `events` one that becomes readable when any interface
 * changes. -1 with errno on failure. */
int link_open(int events);
/* Fills `state`; index 0 when there is no such interface. -1 with errno when the kernel does not answer. */
int link_query(int netlink, const char *name, struct link_state *state);
/* The same by its index, whatever its name is now. */
int link_query_index(int netlink, int index, struct link_state *state);
/* The next event of an events' socket: an interface that is there, or has gone. 1, 0 when there is none, -1 when some were
 * lost. */
struct link_event {
  int gone;
  struct link_state now; /* or as it was at the last */
};
int link_next_event(int netlink, struct link_event *event);
/* The indices of all CAN interfaces; how many, at most n. */
int link_all_can(int netlink, int *index, int n);

/* Can the driver stamp received frames in hardware? */
int link_has_hardware_stamps(const char *name);
/* Asks the driver for it, where it must be asked; it may refuse. What was set before goes into *before, and comes back
 * with link_restore_stamps, whatever the interface is called by then. */
struct link_stamps {
  int asked, index;
  int tx_type, rx_filter;
};
void link_ask_hardware_stamps(int index, struct link_stamps *before);
void link_restore_stamps(const struct link_stamps *before);

/* The names of CAN interfaces, with commas, or "none". */
void link_list(char *out, size_t size);

#endif
