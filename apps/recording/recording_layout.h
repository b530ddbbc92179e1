/* recording_layout.h: which field of a line is which channel (private to recording*.c). */
#ifndef RECORDING_LAYOUT_H
#define RECORDING_LAYOUT_H

#include <stddef.h>
#include <stdint.h>

#include "common/error.h"
#include "talus/channel.h"

#define LAYOUT_MAX_FIELDS 1024

/* One field of a line, [begin, end), without the blanks around it. */
struct field {
  const char *begin, *end;
};

struct layout {
  const char *path;
  tl_plant plant;
  size_t fields;                        /* of each line */
  int8_t slot[LAYOUT_MAX_FIELDS];       /* a field's place in a row, -1 where it is not read */
  int8_t slot_of[TL_CHANNEL_COUNT];     /* a channel's place in a row, -1 where it is missing */
  tl_channel channel[TL_CHANNEL_COUNT]; /* of each place */
  size_t width;                         /* places in a row */
  char unknown[600];                    /* names of the fields that are not read, for a note */
};

/* The field that begins at `c`; it ends at a comma or at `line_end`, and *next is that place. */
struct field layout_field(const char *c, const char *line_end, const char **next);

/* Reads the header line [c, end), number `line`. */
int layout_read(struct layout *layout, const char *path, tl_plant plant, const char *c, const char *end,
                size_t line, struct app_error *error);

/* Parses the line at `c` (somewhere a newline follows) into row[width]: where the
 * next line begins, or NULL when the line is not as simple as most are; then
 * layout_row_strict has the last word. */
const char *layout_row(const struct layout *layout, const char *c, double *row);
/* The same for the line [c, end), blanks around fields allowed, with the error's text.
 * `cut`: it is the file's last line and has no newline. */
int layout_row_strict(const struct layout *layout, const char *c, const char *end, size_t line, int cut,
                      double *row, struct app_error *error);

#endif
