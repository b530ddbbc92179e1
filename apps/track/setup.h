/* setup.h: what talus-track knows before it looks: colours, places, the view, the lens; a YAML file.
 *
 *     struct setup setup;
 *     if (setup_read("setup.yaml", &setup, &error) != 0) return app_exit(&error);
 */
#ifndef TRACK_SETUP_H
#define TRACK_SETUP_H

#include "common/error.h"
#include "talus/marker.h"
#include "track/opencv_face.h"

#define SETUP_NAME 24

struct setup {
  tl_marker_setup mark;
  char name[TL_MARKER_MAX][SETUP_NAME];
  int is_leg; /* knee, ankle, heel, toe in this order, and a view */
  tl_marker_view view;
  char lens_path[512]; /* as the file names it; "" without */
  struct face_lens lens;
  int has_lamp;
  double lamp_px[3]; /* x, y, radius of a sync lamp */
};

/* 0, or -1 with file, line and key. A lens is looked for beside the setup's file. */
int setup_read(const char *path, struct setup *setup, struct app_error *error);
int setup_write(const char *path, const struct setup *setup, struct app_error *error);
/* Markers of the same hue share a colour; whether the names are the leg's. To be called when the markers are set. */
void setup_complete(struct setup *setup, const tl_marker_color color[TL_MARKER_MAX]);
/* Centres without the lens's distortion; flags and covariances stay. */
void setup_undistort(const struct setup *setup, const tl_marker_sample *in, tl_marker_sample *out);

#endif
