/* colors.c: see colors.h. */
#include "track/colors.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define RUNS 200000
#define FOUND 12
#define TOLERANCE_DEG 18.0
#define LEAST_PIXELS 12
#define LEAST_SATURATION 0.3

static tl_image image_of(const struct face_picture *p) {
  const size_t size = p->stride * (size_t)(p->height - 1) + 3 * (size_t)p->width;
  return (tl_image){p->pixel, size, p->stride, p->width, p->height, 3};
}

/* Mean blue, green and red around a place. 0 where it is outside. */
static int mean_color(const struct face_picture *p, double x, double y, double radius, double mean[3]) {
  long n = 0;
  mean[0] = mean[1] = mean[2] = 0.0;
  for (int j = (int)ceil(y - radius); j <= y + radius; j++)
    for (int i = (int)ceil(x - radius); i <= x + radius; i++) {
      if (i < 0 || j < 0 || i >= p->width || j >= p->height || hypot(i - x, j - y) > radius) continue;
      for (int k = 0; k < 3; k++) mean[k] += p->pixel[(size_t)j * p->stride + 3 * (size_t)i + (size_t)k];
      n++;
    }
  for (int k = 0; k < 3 && n; k++) mean[k] /= (double)n;
  return n > 0;
}

/* The class around a mean colour: it may get paler and darker by half. */
static int class_around(const double bgr[3], tl_marker_color *color) {
  const double high = fmax(bgr[0], fmax(bgr[1], bgr[2])), low = fmin(bgr[0], fmin(bgr[1], bgr[2]));
  const double range = high - low;
  if (!(high > 0.0) || range / high < LEAST_SATURATION) return -1;
  double sixth = 4.0 + (bgr[2] - bgr[1]) / range;
  if (high == bgr[2])
    sixth = fmod(6.0 + (bgr[1] - bgr[0]) / range, 6.0);
  else if (high == bgr[1])
    sixth = 2.0 + (bgr[0] - bgr[2]) / range;
  *color = (tl_marker_color){0.1 * rint(600.0 * sixth), TOLERANCE_DEG, 0.01 * rint(55.0 * range / high),
                             0.01 * rint(45.0 * high / 255.0)};
  return 0;
}

/* The piece of the spot's own class that holds its place gives it centre and radius. */
static int settle(const struct face_picture *p, struct spot *spot, tl_marker_run *run) {
  const tl_image image = image_of(p);
  tl_marker_blob blob[FOUND];
  tl_marker_classes classes;
  if (tl_marker_classes_init(&classes, &spot->color, 1) != TL_OK) return -1;
  const int n = tl_marker_find(&classes, &image, 1, blob, FOUND, run, RUNS);
  for (int i = 0; i < n; i++) {
    if (spot->x_px < blob[i].x0 || spot->x_px > blob[i].x1 || spot->y_px < blob[i].y0 ||
        spot->y_px > blob[i].y1)
      continue;
    spot->x_px = 0.01 * rint(100.0 * blob[i].x_px);
    spot->y_px = 0.01 * rint(100.0 * blob[i].y_px);
    spot->radius_px = 0.01 * rint(100.0 * sqrt(blob[i].pixels / 3.14159265358979));
    return spot->radius_px >= 1.5 && spot->radius_px <= 500.0 ? 0 : -1;
  }
  return -1;
}

int colors_at(const struct face_picture *p, double x, double y, struct spot *spot) {
  double mean[3];
  tl_marker_run *run = malloc(RUNS * sizeof *run);
  int result = -1;
  *spot = (struct spot){.x_px = x, .y_px = y};
  if (run && mean_color(p, x, y, 2.0, mean) && class_around(mean, &spot->color) == 0)
    result = settle(p, spot, run);
  free(run);
  return result;
}

static int round_enough(const tl_marker_blob *b) {
  const double wide = b->x1 - b->x0 + 1, high = b->y1 - b->y0 + 1;
  const double fill = b->pixels / (wide * high);
  return b->pixels >= LEAST_PIXELS && wide < 1.5 * high && high < 1.5 * wide && fill > 0.65 && fill < 0.92;
}

static int known(const struct spot *spot, int spots, const tl_marker_blob *b) {
  for (int i = 0; i < spots; i++)
    if (hypot(spot[i].x_px - b->x_px, spot[i].y_px - b->y_px) < spot[i].radius_px) return 1;
  return 0;
}

static void insert(struct spot *spot, int spots, const struct spot *one) {
  int at = spots;
  for (; at > 0 && spot[at - 1].radius_px < one->radius_px; at--) spot[at] = spot[at - 1];
  spot[at] = *one;
}

/* Round pieces of one range of hues. */
static int find_hue(const struct face_picture *p, double hue_deg, struct spot *spot, int spots, int capacity,
                    tl_marker_run *run) {
  const tl_marker_color wide = {hue_deg, 15.0, 0.4, 0.15};
  const tl_image image = image_of(p);
  tl_marker_blob blob[FOUND];
  tl_marker_classes classes;
  if (tl_marker_classes_init(&classes, &wide, 1) != TL_OK) return spots;
  const int n = tl_marker_find(&classes, &image, 1, blob, FOUND, run, RUNS);
  for (int i = 0; i < n && spots < capacity; i++) {
    struct spot one = {.x_px = blob[i].x_px, .y_px = blob[i].y_px};
    double mean[3];
    if (!round_enough(&blob[i]) || known(spot, spots, &blob[i])) continue;
    if (!mean_color(p, one.x_px, one.y_px, 0.5 * sqrt(blob[i].pixels / 3.14159265358979), mean)) continue;
    if (class_around(mean, &one.color) != 0 || settle(p, &one, run) != 0) continue;
    insert(spot, spots++, &one);
  }
  return spots;
}

int colors_find(const struct face_picture *p, struct spot *spot, int capacity) {
  tl_marker_run *run = malloc(RUNS * sizeof *run);
  int spots = 0;
  if (!run) return -1;
  for (int hue = 0; hue < 360; hue += 10) spots = find_hue(p, hue, spot, spots, capacity, run);
  free(run);
  return spots;
}

void colors_separate(struct spot *spot, int spots) {
  for (int i = 0; i < spots; i++)
    for (int k = 0; k < spots; k++) {
      double apart = fabs(spot[i].color.hue_deg - spot[k].color.hue_deg);
      if (apart > 180.0) apart = 360.0 - apart;
      if (i == k || apart < 1.0) continue;
      if (spot[i].color.hue_tolerance_deg > 0.45 * apart)
        spot[i].color.hue_tolerance_deg = 0.1 * rint(4.5 * apart);
    }
}
