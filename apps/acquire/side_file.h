/* side_file.h: first and last line of the JSON lines, and the summary for people. */
#ifndef SIDE_FILE_H
#define SIDE_FILE_H

#include "session.h"

void side_file_header(struct session *s);
void side_file_end(struct session *s);

/* Frames and edges lost or not written, of all sources. */
uint64_t side_file_lost(const struct session *s);
/* On standard error, after the end. */
void side_file_summary(const struct session *s);

#endif
