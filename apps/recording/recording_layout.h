/* recording_layout.h: which column of a file is which channel (private to recording*.c). */
#ifndef RECORDING_LAYOUT_H
#define RECORDING_LAYOUT_H

#include "common/csv.h"
#include "talus/plant.h"

struct layout {
  tl_plant plant;
  tl_channel_set set;
  const char *name[TL_CHANNEL_COUNT]; /* of the plant's channels; they are the header's known names */
  char advice[320];                   /* how such a file would be imported; the header refers to it */
  struct csv_header header;           /* a row's place is column[place] = channel */
};

/* Before the file is read; a layout stays where it is from then on. */
int layout_init(struct layout *layout, const char *path, tl_plant plant, struct app_error *error);
/* After the header, line `line`, has been read: are the plant's columns there? */
int layout_check(struct layout *layout, size_t line, struct app_error *error);

#endif
