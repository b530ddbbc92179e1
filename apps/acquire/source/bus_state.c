/* bus_state.c: error frames of linux/can/error.h. */
#include "bus_state.h"

#include <linux/can/error.h>

#ifndef CAN_ERR_CNT /* since Linux 6.0: bytes 6 and 7 hold the counters */
#define CAN_ERR_CNT 0x00000200U
#endif
#ifndef CAN_ERR_CRTL_ACTIVE
#define CAN_ERR_CRTL_ACTIVE 0x40
#endif

enum { CONTROLLER = 1, TX_ERRORS = 6, RX_ERRORS = 7 }; /* bytes of an error frame */

const char *bus_state_name(enum bus_state state) {
  static const char *const name[] = {"active",  "warning", "passive",  "off",
                                     "stopped", "unknown", "restarted"};
  return name[state];
}

static enum bus_state state_of(uint32_t id, uint8_t controller, enum bus_state now) {
  if (id & CAN_ERR_BUSOFF) return BUS_OFF;
  if (id & CAN_ERR_CRTL) {
    if (controller & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) return BUS_PASSIVE;
    if (controller & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) return BUS_WARNING;
    if (controller & CAN_ERR_CRTL_ACTIVE) return BUS_ACTIVE;
  }
  if (id & CAN_ERR_RESTARTED) return BUS_RESTARTED;
  return now;
}

int bus_fold(struct bus *bus, uint32_t id, const uint8_t data[8]) {
  const enum bus_state before = bus->state;
  if ((id & CAN_ERR_CNT) || data[TX_ERRORS] || data[RX_ERRORS]) {
    bus->tx_errors = data[TX_ERRORS];
    bus->rx_errors = data[RX_ERRORS];
  }
  bus->state = state_of(id, data[CONTROLLER], before);
  return bus->state != before;
}

int bus_says_overflow(uint32_t id, const uint8_t data[8]) {
  return (id & CAN_ERR_CRTL) && (data[CONTROLLER] & CAN_ERR_CRTL_RX_OVERFLOW);
}
