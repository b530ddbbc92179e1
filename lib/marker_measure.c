/* tl_marker_measure.c: the sub-pixel centre of one marker, with what its noise and its shape say. */
#include <math.h>
#include <string.h>

#include "marker_internal.h"

/* Weights below LOW are noise, above HIGH the marker's inside; in between they rise evenly. Symmetric about one
 * half, so that a blurred edge keeps its place. */
#define LOW 0.15
#define HIGH 0.85
#define MIN_CONTRAST 12.0 /* of chroma, in levels */
#define MIN_ROUND 0.85    /* least second moment over that of a disc of this area */

typedef struct disc {
  double x, y, radius, outer; /* pixels; `outer` holds the ring of ground too */
  double core[3], ground[3];  /* mean colours */
  double axis[3], zero;       /* weight of a pixel p = (axis . p) - zero */
  double sigma;               /* of that weight on the ground */
} disc;

typedef struct sums {
  double w, x, y, xx, xy, yy; /* of the weights, about the disc's centre */
  double exx, exy, eyy;       /* of the pixels on the edge, for the noise */
  int saturated;
} sums;

static marker_window window_of(const tl_image *image, const disc *d) {
  return tl_marker_around(image, d->x, d->y, d->outer);
}

static double squared(const disc *d, int x, int y) {
  const double dx = x - d->x, dy = y - d->y;
  return dx * dx + dy * dy;
}

/* Mean colours of the inside (of the class) and of the ring around (of no class). */
static int mean_colors(const tl_marker_classes *classes, const tl_image *image, int class_of, disc *d) {
  const marker_window w = window_of(image, d);
  const double inside = 0.36 * d->radius * d->radius, edge = d->radius + 2.0;
  double core[3] = {0}, ground[3] = {0};
  int cores = 0, grounds = 0;
  for (int y = w.y0; y < w.y1; y++)
    for (int x = w.x0; x < w.x1; x++) {
      const uint8_t *p = marker_pixel(image, x, y);
      const double r2 = squared(d, x, y);
      const int c = marker_class(classes, p);
      if (r2 <= inside && c == class_of) {
        for (int k = 0; k < 3; k++) core[k] += p[k];
        cores++;
      } else if (r2 >= edge * edge && r2 <= d->outer * d->outer && c == 0) {
        for (int k = 0; k < 3; k++) ground[k] += p[k];
        grounds++;
      }
    }
  if (cores < 1 || grounds < 4) return 0;
  for (int k = 0; k < 3; k++) {
    d->core[k] = core[k] / cores;
    d->ground[k] = ground[k] / grounds;
  }
  return 1;
}

/* The axis from ground to core with its grey part taken out, so that grey neighbours weigh nothing. */
static int set_axis(disc *d) {
  double step[3], mean = 0.0, length2 = 0.0;
  for (int k = 0; k < 3; k++) mean += (d->core[k] - d->ground[k]) / 3.0;
  for (int k = 0; k < 3; k++) {
    step[k] = d->core[k] - d->ground[k] - mean;
    length2 += step[k] * step[k];
  }
  if (length2 < MIN_CONTRAST * MIN_CONTRAST) return 0;
  d->zero = 0.0;
  for (int k = 0; k < 3; k++) {
    d->axis[k] = step[k] / length2;
    d->zero += d->axis[k] * d->ground[k];
  }
  return 1;
}

static double coverage(const disc *d, const uint8_t *p) {
  return d->axis[0] * p[0] + d->axis[1] * p[1] + d->axis[2] * p[2] - d->zero;
}

static double weight(double share) {
  if (share <= LOW) return 0.0;
  return share >= HIGH ? 1.0 : (share - LOW) / (HIGH - LOW);
}

/* Spread of the ground's weights: noise and texture. */
static void set_sigma(const tl_marker_classes *classes, const tl_image *image, disc *d) {
  const marker_window w = window_of(image, d);
  const double edge = d->radius + 2.0;
  double sum = 0.0;
  int n = 0;
  for (int y = w.y0; y < w.y1; y++)
    for (int x = w.x0; x < w.x1; x++) {
      const uint8_t *p = marker_pixel(image, x, y);
      const double r2 = squared(d, x, y);
      if (r2 < edge * edge || r2 > d->outer * d->outer || marker_class(classes, p) != 0) continue;
      const double share = coverage(d, p);
      sum += share * share;
      n++;
    }
  d->sigma = n > 0 ? sqrt(sum / n) : 0.0;
}

static void add_pixel(sums *s, double w, double dx, double dy) {
  s->w += w;
  s->x += w * dx;
  s->y += w * dy;
  s->xx += w * dx * dx;
  s->xy += w * dx * dy;
  s->yy += w * dy * dy;
  if (w < 1.0) {
    s->exx += dx * dx;
    s->exy += dx * dy;
    s->eyy += dy * dy;
  }
}

static sums weigh(const tl_image *image, const disc *d) {
  const marker_window window = window_of(image, d);
  sums s;
  memset(&s, 0, sizeof s);
  for (int y = window.y0; y < window.y1; y++)
    for (int x = window.x0; x < window.x1; x++) {
      const uint8_t *p = marker_pixel(image, x, y);
      const double r2 = squared(d, x, y);
      if (r2 > d->outer * d->outer) continue;
      if (p[0] == 255 && p[1] == 255 && p[2] == 255 && r2 < d->radius * d->radius) s.saturated++;
      const double w = weight(coverage(d, p));
      if (w > 0.0) add_pixel(&s, w, x - d->x, y - d->y);
    }
  return s;
}

/* Twice the centre is moved to the weights' mean, so that the cut at the outer radius stands around it. */
static int centre(const tl_image *image, disc *d, sums *s) {
  for (int pass = 0; pass < 3; pass++) {
    *s = weigh(image, d);
    if (!(s->w >= 3.0)) return 0;
    if (pass < 2) {
      d->x += s->x / s->w;
      d->y += s->y / s->w;
    }
  }
  return 1;
}

/* Is the least second moment below that of a disc? Motion blur only adds to it. */
static int flattened(const sums *s) {
  const double mx = s->x / s->w, my = s->y / s->w;
  const double xx = s->xx / s->w - mx * mx, yy = s->yy / s->w - my * my, xy = s->xy / s->w - mx * my;
  const double half = 0.5 * (xx - yy);
  const double least = 0.5 * (xx + yy) - sqrt(half * half + xy * xy);
  return least * 4.0 * 3.14159265358979 < MIN_ROUND * s->w;
}

static int shape_flags(const tl_image *image, const disc *d, const sums *s, double least) {
  const double reach = d->radius + 1.5;
  int flags = TL_MARKER_SEEN;
  if (s->saturated > 0) flags |= TL_MARKER_SATURATED;
  if (flattened(s) || s->w < least) flags |= TL_MARKER_PARTIAL;
  if (d->x < reach || d->y < reach || d->x > image->width - 1 - reach || d->y > image->height - 1 - reach)
    flags |= TL_MARKER_EDGE;
  return flags;
}

/* Noise of each pixel on the edge, carried to the mean; 0.005 px for what no noise shows (chroma of the edge,
 * light that falls off across the disc). */
static void set_covariance(const disc *d, const sums *s, tl_marker_sample *out) {
  const double noise = d->sigma / ((HIGH - LOW) * s->w);
  const double floor2 = 0.005 * 0.005;
  out->cov_px2[0] = noise * noise * s->exx + floor2;
  out->cov_px2[1] = noise * noise * s->exy;
  out->cov_px2[2] = noise * noise * s->eyy + floor2;
}

/* A piece's box may be wider than its disc by motion blur. */
static disc disc_of(const tl_marker_blob *blob) {
  disc d;
  memset(&d, 0, sizeof d);
  const double box =
      0.5 * (1.0 + (blob->x1 - blob->x0 > blob->y1 - blob->y0 ? blob->x1 - blob->x0 : blob->y1 - blob->y0));
  d.x = blob->x_px;
  d.y = blob->y_px;
  d.radius = sqrt(blob->pixels / 3.14159265358979);
  if (box > d.radius) d.radius = box < 1.6 * d.radius ? box : 1.6 * d.radius;
  d.outer = 1.35 * d.radius + 4.0;
  return d;
}

tl_marker_sample tl_marker_measure(const tl_marker_classes *classes, const tl_image *image,
                                   const tl_marker_blob *blob, double area, double least) {
  tl_marker_sample out;
  disc d = disc_of(blob);
  sums s;
  memset(&out, 0, sizeof out);
  if (!mean_colors(classes, image, blob->class_of, &d) || !set_axis(&d)) return out;
  set_sigma(classes, image, &d);
  if (!centre(image, &d, &s)) return out;
  out.flags = shape_flags(image, &d, &s, least * area);
  out.x_px = d.x + s.x / s.w;
  out.y_px = d.y + s.y / s.w;
  out.area_px2 = s.w;
  set_covariance(&d, &s, &out);
  return out;
}
