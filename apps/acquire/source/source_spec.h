/* source_spec.h: a source as the user names it.
 *
 *     can0                                  a CAN interface
 *     gpio:sync=gpiochip0:3:rising          edges of a line; both, rising or falling; pull-up, pull-down
 *     estop:button=gpiochip0:4:falling      the same, and each edge sends the stop frame
 *     pulse:led=gpiochip0:5:10:5            a line driven at 10 Hz, 5 ms high
 *     fd:bench=5                            frames from an inherited datagram socket
 */
#ifndef SOURCE_SPEC_H
#define SOURCE_SPEC_H

#include "common/error.h"
#include "gpio.h"
#include "link.h"

enum source_kind { SOURCE_CAN, SOURCE_GPIO, SOURCE_ESTOP, SOURCE_PULSE, SOURCE_FD };
enum { SOURCE_NAME = LINK_NAME };

struct source_spec {
  enum source_kind kind;
  char name[SOURCE_NAME];
  struct gpio_line line;  /* GPIO, emergency stop, pulse */
  double rate_hz, high_s; /* pulse */
  int fd;
};

/* 0, or -1 with the reason. */
int source_spec_parse(const char *text, struct source_spec *spec, struct app_error *error);
/* "can", "gpio", ... */
const char *source_kind_name(enum source_kind kind);

#endif
