/* item.h: what travels from a source's thread to the writer: one fixed size, whatever it is. */
#ifndef ITEM_H
#define ITEM_H

#include <stdint.h>

enum item_kind {
  ITEM_FRAME,      /* a CAN frame */
  ITEM_ERROR,      /* an error frame */
  ITEM_DROP,       /* number[0] frames lost here, below or in the socket */
  ITEM_LINK,       /* number[0]: enum link_change */
  ITEM_BUS_STATE,  /* the driver's word: number[0] enum bus_state, [1] tx, [2] rx errors */
  ITEM_EDGE,       /* a GPIO edge: number[0] monotonic ns, [1] level, [2] sequence number */
  ITEM_EDGES_LOST, /* number[0] edges lost here */
  ITEM_PULSE,      /* a level driven out: number[0] monotonic ns, [1] level, [2] width of the write in ns */
  ITEM_STOP,       /* the stop frame: number[0] monotonic ns, [1] 0 or an errno, [2] attempts */
  ITEM_CLOCK,      /* number[0..3]: monotonic, realtime, raw, width */
  ITEM_HARDWARE,   /* number[0] hardware ns, [1] realtime ns of one frame */
  ITEM_STATS       /* number[]: in the order of link.h's counters */
};

enum { ITEM_FD = 0x10, ITEM_FLAGS = 0x0f }; /* item.flags: CAN FD's own four bits and whether it is FD */
enum item_where { ITEM_IN_SOCKET, ITEM_IN_INTERFACE };
enum { ITEM_NUMBERS = 8, ITEM_DATA = 64 };

struct item {
  uint8_t kind, source; /* source: index among the session's */
  uint8_t length;       /* bytes of data */
  uint8_t flags;        /* frames: CAN FD; ITEM_DROP: enum item_where */
  uint32_t id;          /* frames: as the kernel has it, with its flags */
  int64_t real_ns;      /* what items are ordered by: realtime, software stamp */
  int64_t hardware_ns;  /* 0: none */
  union {
    uint8_t data[ITEM_DATA];
    int64_t number[ITEM_NUMBERS];
  } is;
};

#endif
