/* marker_tilt.c: the slope of the plane of motion, from links that keep their lengths. */
#include <math.h>

#include "marker_internal.h"
#include "talus/math.h"

typedef struct moments {
  double n, r, rr, j[2], rj[2],
      jj[3]; /* of a length's logarithm (shrinking all gains nothing) and its slopes */
} moments;

static double log_length(const tl_marker_view *view, const double (*point)[2], int link) {
  double a[2], b[2];
  tl_marker_plane_point(view, point[(ptrdiff_t)2 * link], a);
  tl_marker_plane_point(view, point[2 * link + 1], b);
  return tl_log(marker_distance(a[0] - b[0], a[1] - b[1]));
}

static void add_row(moments *m, double r, const double j[2]) {
  m->n += 1.0;
  m->r += r;
  m->rr += r * r;
  for (int k = 0; k < 2; k++) {
    m->j[k] += j[k];
    m->rj[k] += r * j[k];
  }
  m->jj[0] += j[0] * j[0];
  m->jj[1] += j[0] * j[1];
  m->jj[2] += j[1] * j[1];
}

/* Residuals and slopes about their means, which are the link's unknown length. */
static void center(moments *m) {
  m->rr -= m->r * m->r / m->n;
  for (int k = 0; k < 2; k++) m->rj[k] -= m->r * m->j[k] / m->n;
  m->jj[0] -= m->j[0] * m->j[0] / m->n;
  m->jj[1] -= m->j[0] * m->j[1] / m->n;
  m->jj[2] -= m->j[1] * m->j[1] / m->n;
}

static moments link_moments(const tl_marker_view *view, const double (*point)[4][2], size_t n, int link) {
  const double step = 1e-5;
  moments m = {0};
  for (size_t i = 0; i < n; i++) {
    const double length = log_length(view, point[i], link);
    double j[2];
    for (int k = 0; k < 2; k++) {
      tl_marker_view moved = *view;
      moved.tilt[k] += step;
      j[k] = (log_length(&moved, point[i], link) - length) / step;
    }
    add_row(&m, length, j);
  }
  center(&m);
  return m;
}

/* One step of Gauss and Newton; answers its length, negative where the tilt is not determined. */
static double newton(tl_marker_view *view, const double (*point)[4][2], size_t n, double sigma[2]) {
  double a = 0.0, b = 0.0, c = 0.0, p = 0.0, q = 0.0, rr = 0.0;
  for (int link = 0; link < 2; link++) {
    const moments m = link_moments(view, point, n, link);
    a += m.jj[0];
    b += m.jj[1];
    c += m.jj[2];
    p += m.rj[0];
    q += m.rj[1];
    rr += m.rr;
  }
  const double det = a * c - b * b;
  if (!(det > 1e-9 * a * c) || !(a > 0.0)) return -1.0;
  const double dx = -(c * p - b * q) / det, dy = -(a * q - b * p) / det;
  const double left = rr + p * dx + q * dy; /* the sum of squares after the step */
  const double variance = (left > 0.0 ? left : 0.0) / (2.0 * (double)n - 4.0);
  view->tilt[0] += dx;
  view->tilt[1] += dy;
  sigma[0] = sqrt(variance * c / det);
  sigma[1] = sqrt(variance * a / det);
  return marker_distance(dx, dy);
}

tl_status tl_marker_fit_tilt(tl_marker_view *view, const double (*point)[4][2], size_t n, double sigma[2]) {
  if (!view || !point || !sigma || !(view->focal_px > 0.0)) return TL_ERR_ARGUMENT;
  if (n < 20) return TL_ERR_TOO_SHORT;
  tl_marker_view tried = *view;
  double found[2] = {0.0, 0.0};
  tried.tilt[0] = tried.tilt[1] = 0.0;
  for (int pass = 0; pass < 30; pass++) {
    const double moved = newton(&tried, point, n, found);
    if (moved < 0.0 || !(marker_distance(tried.tilt[0], tried.tilt[1]) < 1.0)) return TL_ERR_SINGULAR;
    if (moved > 1e-9) continue;
    for (int k = 0; k < 2; k++) {
      view->tilt[k] = tried.tilt[k];
      sigma[k] = found[k];
    }
    return TL_OK;
  }
  return TL_ERR_NO_CONVERGENCE;
}
