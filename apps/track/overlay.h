/* overlay.h: what was seen, drawn over the pictures: a video, and a sheet of the telling ones. */
#ifndef TRACK_OVERLAY_H
#define TRACK_OVERLAY_H

#include "track/track_file.h"

#define OVERLAY_KINDS 3 /* all whole, some partly hidden, some lost */
#define OVERLAY_EACH 2

struct overlay {
  const struct setup *setup;
  const char *video_path, *sheet_path; /* NULL: not asked for */
  double rate_hz;
  struct face_writer *writer;
  char temporary[1100];
  double last[TL_MARKER_MAX][2]; /* where each was seen last */
  struct face_picture kept[OVERLAY_KINDS][OVERLAY_EACH];
  double kept_s[OVERLAY_KINDS];
  int count[OVERLAY_KINDS];
};

void overlay_begin(struct overlay *overlay, const struct setup *setup, const char *video_path,
                   const char *sheet_path, double rate_hz);
/* Draws into the picture. */
int overlay_add(struct overlay *overlay, const struct face_picture *picture, const struct track_row *row,
                struct app_error *error);
/* Puts the files in their places. */
int overlay_commit(struct overlay *overlay, struct app_error *error);
/* Frees; what was not committed is thrown away. */
void overlay_end(struct overlay *overlay);

#endif
