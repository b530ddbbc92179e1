/* marker.h: coloured round markers in pictures, and the angles of the links that carry them.
 *
 *     tl_marker_setup setup = {.markers = 1, .colors = 1, .color = {{0.0, 20.0, 0.5, 0.3}}, // red
 *                              .start_px = {{60.0, 40.0}}, .radius_px = {8.0}};
 *     tl_marker_classes classes;
 *     tl_marker_state state;
 *     tl_marker_sample seen[TL_MARKER_MAX];
 *     static tl_marker_run run[4096];
 *     if (tl_marker_classes_init(&classes, setup.color, setup.colors) != TL_OK ||
 *         tl_marker_start(&setup, &state) != TL_OK) return 1;
 *     for (double t_s = 0.0; next_picture(&image); t_s += 1.0 / 60.0)
 *       if (tl_marker_track(&setup, &classes, &state, &image, t_s, seen, run, 4096) != TL_OK) return 1;
 *     printf("%.2f %.2f\n", seen[0].x_px, seen[0].y_px); // prints 62.00 40.00
 *
 * A picture is looked at where the markers are expected; only for a marker that is not found there the
 * whole picture is searched, on a coarse grid. A centre is the mean of the pixels' positions, weighted by the
 * share of each pixel that the marker covers. That share comes from the pixel's chroma (its colour less its
 * grey), so that grey things near a marker do not move it.
 */
#ifndef TALUS_MARKER_H
#define TALUS_MARKER_H

#include <stddef.h>
#include <stdint.h>

#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_MARKER_MAX 4             /* markers, and colours */
#define TL_MARKER_CLASS_CELLS 32768 /* 5 bits of each of blue, green and red */

/* A picture of 8-bit blue, green, red (, unused): pixel (x, y) begins at byte y * stride + x * channels. Nothing
 * at or beyond byte `size` is read. Pixel centres have whole coordinates, x to the right, y down. */
typedef struct tl_image {
  const uint8_t *pixel;
  size_t size, stride;
  int width, height; /* 1 .. 32767 */
  int channels;      /* 3 or 4 */
} tl_image;

/* A class of colours: hue 0..360 (0 red, 120 green, 240 blue) within a tolerance below 90, at least so
 * saturated and so bright (0..1, saturation above 0). Saturation is (max - min) / max of the three, value max / 255. */
typedef struct tl_marker_color {
  double hue_deg, hue_tolerance_deg;
  double min_saturation, min_value;
} tl_marker_color;

/* The class of each cell of colours: 0 none, c + 1 for color[c]. Where two classes overlap the nearer hue has
 * the cell. */
typedef struct tl_marker_classes {
  uint8_t of[TL_MARKER_CLASS_CELLS];
} tl_marker_classes;

/* TL_ERR_RANGE for a colour outside the ranges above. */
TL_CHECK tl_status tl_marker_classes_init(tl_marker_classes *classes, const tl_marker_color *color,
                                          int colors);

/* What is known before the first picture. */
typedef struct tl_marker_setup {
  int markers, colors; /* 1 .. TL_MARKER_MAX */
  tl_marker_color color[TL_MARKER_MAX];
  int color_of[TL_MARKER_MAX];       /* the colour of each marker; several may have the same */
  double start_px[TL_MARKER_MAX][2]; /* where each was at calibration: parts markers of one colour */
  double radius_px[TL_MARKER_MAX];   /* about; 1.5 .. 500 */
  int link[2][2];                    /* pairs of markers on one body: their distance tells identities apart */
  int links;                         /* 0 .. 2 */
} tl_marker_setup;

/* What is known of a marker. */
enum {
  TL_MARKER_SEEN = 1,       /* the centre is measured; without it the marker is lost in this picture */
  TL_MARKER_PARTIAL = 2,    /* part of it is hidden: the centre is off */
  TL_MARKER_SATURATED = 4,  /* some of its pixels are at 255 in all of blue, green and red: a highlight */
  TL_MARKER_MERGED = 8,     /* it touches another of its colour: not measured */
  TL_MARKER_EDGE = 16,      /* it touches the edge of the picture */
  TL_MARKER_REACQUIRED = 32 /* found by searching the whole picture */
};

/* A marker in one picture. Without TL_MARKER_SEEN all numbers are 0. */
typedef struct tl_marker_sample {
  int flags;
  double x_px, y_px;
  double cov_px2[3]; /* of (x, x), (x, y), (y, y): from the noise around the marker */
  double area_px2;
} tl_marker_sample;

/* What tracking remembers of a marker; for the library only. */
typedef struct tl_marker_memory {
  int known, lost; /* a position is known; pictures since */
  double x, y, vx, vy, t_s;
  double area, area_spread;      /* px^2, and the variance of its share */
  double last_area, area_jitter; /* of the picture before, and the variance between pictures as a share */
  int areas;                     /* how many pictures `area` rests on */
} tl_marker_memory;

typedef struct tl_marker_state {
  tl_marker_memory marker[TL_MARKER_MAX];
  double length_px[2]; /* of the links, 0 unknown */
  int searched;        /* was the whole last picture searched? */
} tl_marker_state;

/* Part of a row that is of one class; workspace. */
typedef struct tl_marker_run {
  int x0, x1, y, root;
  uint8_t class_of;
} tl_marker_run;

/* TL_ERR_ARGUMENT or TL_ERR_RANGE for an impossible setup. */
TL_CHECK tl_status tl_marker_start(const tl_marker_setup *setup, tl_marker_state *state);

/* One picture, taken at t_s (times rise): sample[markers]. `runs` limits the coloured pieces of rows that are
 * looked at in a window or in the whole picture: 4,096 serve 1080p; where they do not suffice (a picture full of colour) the rest
 * is not searched. TL_ERR_ARGUMENT for an image that does not lie within its bytes, TL_ERR_RANGE for a time that does not rise. */
TL_CHECK tl_status tl_marker_track(const tl_marker_setup *setup, const tl_marker_classes *classes,
                                   tl_marker_state *state, const tl_image *image, double t_s,
                                   tl_marker_sample *sample, tl_marker_run *run, size_t runs);

/* A coloured piece of a picture. */
typedef struct tl_marker_blob {
  int class_of;       /* colour + 1 */
  int pixels;         /* grid points */
  double x_px, y_px;  /* their mean */
  int x0, y0, x1, y1; /* its box, both ends within */
} tl_marker_blob;

/* The largest connected pieces of each class in the whole picture on a grid of `step` pixels, at most
 * `capacity`, largest first; answers how many, 0 for an impossible image. */
int tl_marker_find(const tl_marker_classes *classes, const tl_image *image, int step, tl_marker_blob *blob,
                   int capacity, tl_marker_run *run, size_t runs);

/* How the camera sees the plane in which the leg moves. Pixels must be free of lens distortion. */
typedef struct tl_marker_view {
  double focal_px;     /* 0: unknown, the tilt is then taken as 0 */
  double center_px[2]; /* the lens's principal point */
  double tilt[2];      /* slopes of the plane's depth to the right and down: Z = Z0 + tilt[0] X + tilt[1] Y */
  double vertical_rad; /* of the plumb line in the plane: what a hanging link shows before it is corrected */
  int clockwise;       /* positive angles turn clockwise (1) or counterclockwise (0) in the picture */
  double shank_length_m;
  double shank_offset_rad, foot_offset_rad; /* the markers' line on each link less the link's own line */
} tl_marker_view;

/* Angles of both links from four markers: knee, ankle, then two on the foot. */
typedef struct tl_marker_angles {
  int shank_valid, foot_valid; /* both markers of it were seen whole */
  double shank_rad, foot_rad;  /* absolute, from the vertical */
  double shank_sigma_rad, foot_sigma_rad;
  double scale_m_px; /* by the shank's length */
} tl_marker_angles;

/* A point of the picture in the plane of motion, in pixels at the principal point's depth. */
void tl_marker_plane_point(const tl_marker_view *view, const double px[2], double plane[2]);
/* Angle of the line between two points in the plane, from the picture's vertical, in the view's sense. */
double tl_marker_direction(const tl_marker_view *view, const double from_px[2], const double to_px[2]);
void tl_marker_angles_from(const tl_marker_view *view, const tl_marker_sample sample[4],
                           tl_marker_angles *out);

/* The plane's tilt from motion: with the right one, both links keep their lengths. point[n][4][2] are pictures' centres
 * [px]. Needs focal_px; sets view->tilt and sigma[2]. TL_ERR_TOO_SHORT below 20 pictures, TL_ERR_SINGULAR when
 * nothing turns. */
TL_CHECK tl_status tl_marker_fit_tilt(tl_marker_view *view, const double (*point)[4][2], size_t n,
                                      double sigma[2]);

#ifdef __cplusplus
}
#endif
#endif
