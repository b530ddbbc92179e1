/* watch.h: what the main thread does while others record: clocks, interfaces, the live line. */
#ifndef WATCH_H
#define WATCH_H

#include "session.h"

/* Into the session's ring of events. */
void watch_push(struct session *s, const struct item *item);
void watch_clock(struct session *s);
/* Interfaces up and down, their counters and bus states; `report` writes statistics in any case. */
void watch_links(struct session *s, int report);
/* One line on standard error, over the last one. */
void watch_live_line(struct session *s);
/* What is printed next begins a line of its own. */
void watch_live_end(void);

#endif
