/* track_file.c: see track_file.h. */
#include "track/track_file.h"

#include <math.h>

void track_file_header(struct output *out, const struct setup *setup) {
  output_text(out, "time_s");
  for (int m = 0; m < setup->mark.markers; m++) {
    const char *name = setup->name[m];
    output_printf(out, ",%s_x_px,%s_y_px,%s_sigma_px,%s_flags", name, name, name, name);
  }
  if (setup->has_lamp) output_text(out, ",lamp");
  if (setup->is_leg) output_text(out, ",shank_rad,shank_sigma_rad,foot_rad,foot_sigma_rad");
  output_text(out, "\n");
}

static void field(struct output *out, int there, double x) {
  output_text(out, ",");
  output_number(out, there ? x : 0.0);
}

static void marker_fields(struct output *out, const tl_marker_sample *sample) {
  const int seen = sample->flags & TL_MARKER_SEEN;
  field(out, seen, sample->x_px);
  field(out, seen, sample->y_px);
  field(out, seen, sqrt(0.5 * (sample->cov_px2[0] + sample->cov_px2[2])));
  field(out, 1, sample->flags);
}

void track_file_row(struct output *out, const struct setup *setup, const struct track_row *row) {
  output_exact(out, row->t_s);
  for (int m = 0; m < setup->mark.markers; m++) marker_fields(out, &row->sample[m]);
  if (setup->has_lamp) field(out, 1, row->lamp);
  if (setup->is_leg) {
    field(out, row->angles.shank_valid, row->angles.shank_rad);
    field(out, row->angles.shank_valid, row->angles.shank_sigma_rad);
    field(out, row->angles.foot_valid, row->angles.foot_rad);
    field(out, row->angles.foot_valid, row->angles.foot_sigma_rad);
  }
  output_text(out, "\n");
}
