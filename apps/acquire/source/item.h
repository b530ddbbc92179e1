/* item.h: what travels from a source's thread to the writer: one fixed size, whatever it is. */
#ifndef ITEM_H
#define ITEM_H

#include <stdint.h>

#include "acquire/host/clocks.h"

enum item_kind {
  ITEM_FRAME,      /* a CAN frame: data */
  ITEM_ERROR,      /* an error frame: data */
  ITEM_DROP,       /* drop */
  ITEM_LINK,       /* link */
  ITEM_VANISHED,   /* vanished: what an interface that is gone had counted */
  ITEM_BUS_STATE,  /* bus: the driver's word */
  ITEM_EDGE,       /* edge: of a GPIO line */
  ITEM_EDGES_LOST, /* edges_lost */
  ITEM_PULSE,      /* pulse: a level driven out */
  ITEM_STOP,       /* stop: what an emergency edge sent */
  ITEM_STOP_PATH,  /* stop_path: could it be sent now? */
  ITEM_CLOCK,      /* clock */
  ITEM_HARDWARE,   /* stamps: both of one frame */
  ITEM_STATS       /* counter: in the order of link.h's */
};

/* What a source's account counts one by one. */
#define ITEM_IS_COUNTED(kind) ((kind) == ITEM_FRAME || (kind) == ITEM_EDGE || (kind) == ITEM_PULSE)

enum { ITEM_FD = 0x10, ITEM_FLAGS = 0x0f }; /* item.flags: CAN FD's own four bits and whether it is FD */
enum item_where { ITEM_IN_SOCKET, ITEM_IN_INTERFACE };
enum { ITEM_COUNTERS = 8, ITEM_DATA = 64, ITEM_NAME = 16 };

struct item {
  uint8_t kind, source; /* source: index among the session's */
  uint8_t length;       /* bytes of data */
  uint8_t flags;        /* frames: CAN FD; ITEM_CLOCK: 1 when the clock was just set */
  uint32_t id;          /* frames: as the kernel has it, with its flags */
  int64_t real_ns;      /* what items are ordered by: realtime, software stamp */
  int64_t hardware_ns;  /* 0: none */
  union {
    uint8_t data[ITEM_DATA];
    struct {
      uint64_t lost;
      int where;   /* enum item_where */
      int counter; /* in the interface: enum link_counter */
    } drop;        /* frames lost at this place of the record */
    struct {
      int change; /* enum link_change */
      int index;
      char name[ITEM_NAME]; /* that the interface has now */
    } link;
    struct {
      int index, unknown;
      uint64_t received, read, lost, more; /* as in tally.h */
    } vanished;
    struct {
      int state, tx_errors, rx_errors;
    } bus;
    struct {
      int64_t mono_ns;
      int level;
      uint32_t sequence;
    } edge;
    struct {
      uint64_t lost;
      int64_t mono_ns; /* of the edge behind the gap */
    } edges_lost;
    struct {
      int64_t mono_ns, width_ns; /* the write took so long */
      int level;
    } pulse;
    struct {
      int64_t mono_ns;
      int frames;  /* that went out */
      int failure; /* errno of the last that did not, 0 */
      int attempts;
    } stop;
    struct {
      int ready, failure; /* errno: why it could not be sent */
    } stop_path;
    struct clock_triple clock;
    struct {
      int64_t hardware_ns, real_ns;
    } stamps;
    uint64_t counter[ITEM_COUNTERS];
  } is;
};

#endif
