/* source.h: where records come from: one thread each, one ring each.
 *
 *     source_open(&source, &spec, index, &settings, &error);
 *     poll source.fd and source.events; source.ops->read(&source);     on the source's thread
 *     source.ops->finish(&source);                   what is still in the kernel, and what was lost
 *     source_close(&source);
 */
#ifndef SOURCE_H
#define SOURCE_H

#include "acquire/host/stamp_pair.h"
#include "can_port.h"
#include "ring.h"
#include "source_spec.h"
#include "tally.h"

enum { RECEIVE_BYTES = 4 << 20, FORMER = 16 };

struct source;
struct stop_line;

/* What a kind of source consists of. */
struct source_ops {
  int (*open)(struct source *source, struct app_error *error);
  int (*read)(struct source *source);    /* all that is there; -1 with errno when the source is lost */
  void (*finish)(struct source *source); /* no more from now on; drains, and reads drop counters */
  void (*close)(struct source *source);
};

struct source_settings {
  uint64_t receive_bytes; /* wanted of the socket's buffer */
  int software_stamps;    /* do not use the adapter's clock */
  const struct gpio_backend *gpio;
  struct stop_line *stop; /* what an emergency edge sends; NULL none */
};

/* Counted by the source's thread, where it happens; others look with source_count. */
struct source_counts {
  uint64_t read;             /* messages had from the kernel; edges */
  uint64_t frames;           /* of them: frames to be written, or edges */
  uint64_t errors;           /* error frames */
  uint64_t malformed;        /* messages of an inherited socket that are no frames */
  uint64_t foreign;          /* of other interfaces, before they were left out */
  uint64_t lost;             /* by the kernel, known so far */
  uint64_t abandoned;        /* of `frames`, not put into the ring: the writer was dead */
  uint64_t events_abandoned; /* all else that was not, for the same reason */
};

enum vanished_state { SETTLED, JUST_GONE, BEING_READ };

/* An interface that is gone. Its last frames may still be queued: it is settled when the queue has been empty since. */
struct vanished {
  struct tally tally;
  uint64_t counter[LINK_COUNTERS]; /* the last that the kernel said of it */
  int state;                       /* enum vanished_state */
};

struct source {
  struct source_spec spec;
  const struct source_settings *settings;
  const struct source_ops *ops;
  uint8_t index;
  int fd;     /* polled; -1 while there is none */
  int events; /* polled as well: the kernel's word about interfaces; -1 none */
  struct ring ring;
  struct source_counts count;

  /* CAN */
  struct can_port port;
  int gone;                         /* the interface does not exist at the moment */
  struct vanished vanished[FORMER]; /* those that had the name and are gone, the last one first */
  struct tally tally;               /* of the interface that is recorded now */
  int finishing;                    /* what comes from now on is left out */
  int excluded[CAN_PORT_EXCLUDED], excluded_count;
  struct link_state link; /* as it was at the start */
  struct link_stamps stamps_before;
  int hardware_stamps;
  int takes_fd_frames;
  int receive_buffer;      /* bytes that the kernel granted */
  uint32_t drops_seen;     /* of the socket's counter, already reported */
  uint32_t at_once;        /* messages that were there when it was last read */
  int64_t last_ns;         /* stamp of the last frame that was read */
  struct can_batch *batch; /* buffers of the reader */
  struct stamp_pair pair;  /* for the clock's record */

  /* GPIO */
  struct gpio *gpio;
  uint32_t sequence; /* of the last edge */
  int pressed;       /* emergency stop, at the start: 1 pressed, 0 not, -1 not known */
  int value;         /* pulse: level that is driven */
  int64_t next_ns;   /* pulse: when it changes */

  /* what others may look at while it runs */
  uint64_t stops;                /* emergency edges that were answered */
  int stop_frames, stop_failure; /* of the last one: frames that went out, errno of one that did not */
  int failure;                   /* errno: reading it failed */
  int writer_dead;
  int ended; /* an inherited socket's other end is closed */
};

int source_open(struct source *source, const struct source_spec *spec, uint8_t index,
                const struct source_settings *settings, struct app_error *error);
void source_close(struct source *source);

/* Does it bring frames, and not edges? */
int source_is_can(const struct source *source);

/* Into the ring; waits where it is full, so that what cannot be kept stays in the kernel, which counts
 * what it drops. */
void source_push(struct source *source, const struct item *item);
/* For the next try at a ring that is full; 0: the writer is dead. */
int source_wait_for_room(const struct source *source);

/* By the source's thread alone; and a look at it by any thread. */
void source_add(uint64_t *count, uint64_t more);
uint64_t source_count(const uint64_t *count);

extern const struct source_ops source_can, source_fd, source_gpio, source_pulse;

#endif
