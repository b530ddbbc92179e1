/* colors.h: round coloured things in a picture, and the classes of colour that hold them. */
#ifndef TRACK_COLORS_H
#define TRACK_COLORS_H

#include "talus/marker.h"
#include "track/opencv_face.h"

/* A thing that may be a marker. */
struct spot {
  tl_marker_color color;
  double x_px, y_px, radius_px;
};

/* The round things of strong colour, largest first; each once. -1 when out of memory. */
int colors_find(const struct face_picture *picture, struct spot *spot, int capacity);
/* The coloured thing at a place. 0, or -1 where the colour is too weak to follow. */
int colors_at(const struct face_picture *picture, double x, double y, struct spot *spot);
/* Narrows tolerances so that the classes of different spots do not overlap. */
void colors_separate(struct spot *spot, int spots);

#endif
