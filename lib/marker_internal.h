/* marker_internal.h: what the sources of the marker module share. */
#ifndef TL_MARKER_INTERNAL_H
#define TL_MARKER_INTERNAL_H

#include <math.h>

#include "talus/marker.h"

#define MARKER_CANDIDATES 24

/* A part of a picture, [x0, x1) by [y0, y1). */
typedef struct marker_window {
  int x0, y0, x1, y1;
} marker_window;

static inline const uint8_t *marker_pixel(const tl_image *image, int x, int y) {
  return image->pixel + (size_t)y * image->stride + (size_t)x * (size_t)image->channels;
}

static inline uint8_t marker_class(const tl_marker_classes *classes, const uint8_t *p) {
  return classes->of[(p[0] >> 3 << 10) | (p[1] >> 3 << 5) | (p[2] >> 3)];
}

static inline double marker_distance(double x, double y) {
  return sqrt(x * x + y * y);
}

/* Does every pixel lie within the image's bytes? */
int tl_marker_image_sound(const tl_image *image);

/* The window that reaches `half` pixels around a point, cut at the picture's edges; empty where the point is far
 * outside. */
marker_window tl_marker_around(const tl_image *image, double x, double y, double half);

/* Connected pieces of one class (0: of each) in a window on a grid; the largest `capacity`, largest first. */
int tl_marker_blobs(const tl_marker_classes *classes, const tl_image *image, marker_window window, int step,
                    int only, tl_marker_blob *blob, int capacity, tl_marker_run *run, size_t runs);

/* Sub-pixel centre of a piece of colour; `area` is what its whole area should be (0 unknown), and below the share `least` of it
 * a part is hidden. Without
 * enough contrast the answer's flags are 0. */
tl_marker_sample tl_marker_measure(const tl_marker_classes *classes, const tl_image *image,
                                   const tl_marker_blob *blob, double area, double least);

/* Which candidate each marker is, or -1: pick[markers]. */
typedef struct marker_choice {
  const tl_marker_setup *setup;
  const tl_marker_state *state;
  const tl_marker_blob *blob; /* candidates, on the picture's own grid */
  int blobs;
  double predicted[TL_MARKER_MAX][2];
  double gate[TL_MARKER_MAX]; /* pixels */
  double t_s;
} marker_choice;

void tl_marker_assign(const marker_choice *choice, int *pick);

#endif
