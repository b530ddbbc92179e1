/* bus_state.h: what a stream of error frames says about the bus. */
#ifndef BUS_STATE_H
#define BUS_STATE_H

#include <stdint.h>

enum bus_state { BUS_ACTIVE, BUS_WARNING, BUS_PASSIVE, BUS_OFF, BUS_STOPPED, BUS_UNKNOWN, BUS_RESTARTED };

struct bus {
  enum bus_state state;
  int tx_errors, rx_errors; /* the controller's counters, -1: not said yet */
};

const char *bus_state_name(enum bus_state state);

/* An error frame (id and data as the kernel gives them) into `bus`. 1 when the state has changed. */
int bus_fold(struct bus *bus, uint32_t id, const uint8_t data[8]);
/* Does the frame say that the controller lost frames that it had received? */
int bus_says_overflow(uint32_t id, const uint8_t data[8]);

#endif
