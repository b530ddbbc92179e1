/* track_file.h: the table that talus-track writes, a line for each picture. */
#ifndef TRACK_TRACK_FILE_H
#define TRACK_TRACK_FILE_H

#include "common/output.h"
#include "track/setup.h"

/* One picture as it was understood. */
struct track_row {
  double t_s, lamp; /* brightness 0..1, NaN without a lamp */
  tl_marker_sample sample[TL_MARKER_MAX];
  tl_marker_angles angles;
};

/* Columns: time_s; of each marker NAME_x_px, NAME_y_px, NAME_sigma_px, NAME_flags; lamp; and of a leg shank_rad, shank_sigma_rad,
 * foot_rad, foot_sigma_rad. Of what was not seen whole the number and its sigma are 0; no sigma is 0 otherwise. */
void track_file_header(struct output *out, const struct setup *setup);
void track_file_row(struct output *out, const struct setup *setup, const struct track_row *row);

#endif
