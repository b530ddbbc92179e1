/* csv_field.h: the one place that splits a line (private to csv*.c). */
#ifndef CSV_FIELD_H
#define CSV_FIELD_H

#include <string.h>

#include "csv.h"

static inline int csv_is_blank(char c) {
  return c == ' ' || c == '\t';
}

/* The field that begins at `c`; it ends at a separator or at `line_end`, and *next is that place. */
static inline struct csv_field csv_field(const char *c, const char *line_end, char separator,
                                         const char **next) {
  const char *stop = memchr(c, separator, (size_t)(line_end - c));
  struct csv_field field = {c, stop ? stop : line_end};
  *next = field.end;
  while (field.begin < field.end && csv_is_blank(*field.begin)) field.begin++;
  while (field.end > field.begin && csv_is_blank(field.end[-1])) field.end--;
  return field;
}

int csv_header_line(struct csv_header *h, const char *c, const char *end, size_t line,
                    struct app_error *error);

#endif
