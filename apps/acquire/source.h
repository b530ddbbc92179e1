/* source.h: where records come from: one thread each, one ring each.
 *
 *     source_open(&source, &spec, index, &settings, &error);
 *     poll source.fd; source.face->read(&source);     on the source's thread
 *     source.face->finish(&source);                   what is still in the kernel, and what was lost
 *     source_close(&source);
 */
#ifndef SOURCE_H
#define SOURCE_H

#include <linux/can.h>

#include "ring.h"
#include "source_spec.h"

enum { STOP_FRAMES = 3, RECEIVE_BYTES = 4 << 20 };

struct source;

/* What a kind of source consists of. */
struct source_face {
  int (*open)(struct source *source, struct app_error *error);
  int (*read)(struct source *source);    /* all that is there; -1 with errno when the source is lost */
  void (*finish)(struct source *source); /* no more from now on; drains, and reads drop counters */
  void (*close)(struct source *source);
};

/* The stop line: a socket that is ready, and what to send on it. */
struct stop_line {
  int fd; /* -1: none */
  struct can_frame frame[STOP_FRAMES];
  int *playing; /* set to 1 first: nobody plays on. Nullable */
};

struct source_settings {
  uint64_t receive_bytes; /* wanted of the socket's buffer */
  int software_stamps;    /* do not use the adapter's clock */
  const struct gpio_backend *gpio;
  const struct stop_line *stop; /* what an emergency edge sends */
};

struct source {
  struct source_spec spec;
  const struct source_settings *settings;
  const struct source_face *face;
  uint8_t index;
  int fd; /* polled; -1 while there is none */
  struct ring ring;

  /* CAN */
  struct link_state link; /* as it was at the start */
  int hardware_stamps;
  int takes_fd_frames;
  int receive_buffer;       /* bytes that the kernel granted */
  uint32_t drops_seen;      /* of the socket's counter, already reported */
  uint32_t at_once;         /* messages that were there when it was last read */
  struct can_batch *batch;  /* buffers of the reader */
  int64_t pair_hardware_ns; /* one frame's two stamps, for the clock's record */
  int64_t pair_real_ns;

  /* GPIO */
  struct gpio *gpio;
  uint32_t sequence; /* of the last edge */
  int value;         /* pulse: level that is driven */
  int64_t next_ns;   /* pulse: when it changes */

  /* what others may look at while it runs */
  uint64_t seen;      /* frames or edges */
  uint64_t lost;      /* by the kernel, known so far */
  uint64_t abandoned; /* had, and not written: the writer was dead */
  uint64_t malformed; /* messages of an inherited socket that are no frames */
  int writer_dead;
  int ended; /* an inherited socket's other end is closed */
};

int source_open(struct source *source, const struct source_spec *spec, uint8_t index,
                const struct source_settings *settings, struct app_error *error);
void source_close(struct source *source);

/* Into the ring; waits where it is full, so that what cannot be kept stays in the kernel, which counts
 * what it drops. */
void source_push(struct source *source, const struct item *item);

/* The stop frames, at once, and the record of it. */
void source_send_stop(struct source *source, const struct stop_line *stop);

extern const struct source_face source_can, source_fd, source_gpio, source_pulse;

#endif
