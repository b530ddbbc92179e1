/* stop_line.h: the socket and the frames that an emergency edge sends. */
#ifndef STOP_LINE_H
#define STOP_LINE_H

#include "common/error.h"
#include "source.h"

/* "can0" (the bench's own Stop frame, docs of leg_bus.h) or "can0:001#0011". */
int stop_line_open(struct stop_line *stop, const char *text, struct app_error *error);

#endif
