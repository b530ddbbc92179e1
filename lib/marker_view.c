/* marker_view.c: from centres in the picture to angles of links in their plane of motion. */
#include <math.h>
#include <string.h>

#include "marker_internal.h"
#include "talus/math.h"

/* A ray (u, v, 1) meets the plane Z = Z0 + a X + b Y at Z = Z0 / (1 - a u - b v). The axes in the plane are e1 along (1, 0, a)
 * and e2 across it, so that without tilt they are the picture's. */
void tl_marker_plane_point(const tl_marker_view *view, const double px[2], double plane[2]) {
  const double dx = px[0] - view->center_px[0], dy = px[1] - view->center_px[1];
  const double a = view->tilt[0], b = view->tilt[1], f = view->focal_px;
  if (!(f > 0.0)) {
    plane[0] = dx;
    plane[1] = dy;
    return;
  }
  const double depth = f / (1.0 - (a * dx + b * dy) / f);
  const double x = depth * dx / f, y = depth * dy / f, z = depth - f; /* from the point on the axis */
  const double e1 = sqrt(1.0 + a * a), normal = sqrt(1.0 + a * a + b * b);
  plane[0] = (x + a * z) / e1;
  /* e2 = n x e1 with n = (-a, -b, 1) / normal, e1 = (1, 0, a) / e1 */
  plane[1] = (-a * b * x + (1.0 + a * a) * y + b * z) / (normal * e1);
}

static double angle_of(const tl_marker_view *view, double dx, double dy) {
  /* 0 points down in the picture; clockwise carries the lower end to the left */
  return view->clockwise ? tl_atan2(-dx, dy) : tl_atan2(dx, dy);
}

double tl_marker_direction(const tl_marker_view *view, const double from_px[2], const double to_px[2]) {
  double from[2], to[2];
  tl_marker_plane_point(view, from_px, from);
  tl_marker_plane_point(view, to_px, to);
  return angle_of(view, to[0] - from[0], to[1] - from[1]);
}

static double wrapped(double angle) {
  return angle - 2.0 * TL_PI * floor(angle / (2.0 * TL_PI) + 0.5);
}

/* Variance of the line's direction: both centres' covariances across the line, over its length squared. */
static double direction_sigma(const tl_marker_sample *a, const tl_marker_sample *b) {
  const double dx = b->x_px - a->x_px, dy = b->y_px - a->y_px, length2 = dx * dx + dy * dy;
  double across = 0.0;
  const double c[3] = {a->cov_px2[0] + b->cov_px2[0], a->cov_px2[1] + b->cov_px2[1],
                       a->cov_px2[2] + b->cov_px2[2]};
  if (!(length2 > 0.0)) return 0.0;
  across = (dy * dy * c[0] - 2.0 * dx * dy * c[1] + dx * dx * c[2]) / length2;
  return sqrt(across / length2);
}

static int whole(const tl_marker_sample *a, const tl_marker_sample *b) {
  const int spoilt = TL_MARKER_PARTIAL | TL_MARKER_EDGE | TL_MARKER_MERGED;
  return a->flags & b->flags & TL_MARKER_SEEN && !((a->flags | b->flags) & spoilt);
}

void tl_marker_angles_from(const tl_marker_view *view, const tl_marker_sample sample[4],
                           tl_marker_angles *out) {
  double point[4][2], ends[2][2];
  memset(out, 0, sizeof *out);
  for (int m = 0; m < 4; m++) {
    point[m][0] = sample[m].x_px;
    point[m][1] = sample[m].y_px;
  }
  out->shank_valid = whole(&sample[0], &sample[1]);
  out->foot_valid = whole(&sample[2], &sample[3]);
  if (out->shank_valid) {
    const double line = tl_marker_direction(view, point[0], point[1]);
    out->shank_rad = wrapped(line - view->vertical_rad - view->shank_offset_rad);
    out->shank_sigma_rad = direction_sigma(&sample[0], &sample[1]);
    tl_marker_plane_point(view, point[0], ends[0]);
    tl_marker_plane_point(view, point[1], ends[1]);
    const double length = marker_distance(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]);
    out->scale_m_px = length > 0.0 ? view->shank_length_m / length : 0.0;
  }
  if (out->foot_valid) {
    const double line = tl_marker_direction(view, point[2], point[3]);
    out->foot_rad = wrapped(line - view->vertical_rad - view->foot_offset_rad);
    out->foot_sigma_rad = direction_sigma(&sample[2], &sample[3]);
  }
}
