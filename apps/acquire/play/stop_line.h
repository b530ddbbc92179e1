/* stop_line.h: what an emergency edge sends, by a socket that is ready whatever was plugged in or out meanwhile.
 *
 *     stop_line_open(&stop, "can0:001#0011", &error);
 *     stop_line_send(&stop, &item);          on the thread that reads the button
 *     stop_line_path(&stop, netlink)         elsewhere: could it be sent now?
 */
#ifndef STOP_LINE_H
#define STOP_LINE_H

#include "acquire/source/can_port.h"
#include "acquire/source/item.h"
#include "common/error.h"

enum { STOP_FRAMES = 3 };

struct stop_line {
  struct can_port port;
  struct can_frame frame[STOP_FRAMES];
  int told;     /* an eventfd: readable after a stop */
  int *playing; /* set to 1 first: nobody plays on. Nullable */
};

/* "can0" (the bench's own Stop frame, docs of leg_bus.h) or "can0:001#0011". */
int stop_line_open(struct stop_line *stop, const char *text, struct app_error *error);
void stop_line_close(struct stop_line *stop);

/* The frames, at once, and how it went into item->is.stop. */
void stop_line_send(struct stop_line *stop, struct item *item);
/* Wakes up whoever polls `told`. */
void stop_line_tell(const struct stop_line *stop);

/* 0 when a frame could be sent now, else an errno: ENODEV not there, ENETDOWN down or bus-off. */
int stop_line_path(const struct stop_line *stop, int netlink);

#endif
