/* marker.c: pictures that can be trusted, and classes of colours. */
#include "talus/marker.h"

#include <math.h>
#include <string.h>

#include "marker_internal.h"

int tl_marker_image_sound(const tl_image *image) {
  if (!image || !image->pixel || (image->channels != 3 && image->channels != 4)) return 0;
  if (image->width < 1 || image->height < 1 || image->width > 32767 || image->height > 32767) return 0;
  const size_t row = (size_t)image->width * (size_t)image->channels, rows = (size_t)image->height - 1;
  if (image->stride < row || image->size < row) return 0;
  return rows == 0 || image->stride <= (image->size - row) / rows;
}

static int clamped(double x, int high) {
  if (!(x > 0.0)) return 0;
  return x < (double)high ? (int)x : high;
}

marker_window tl_marker_around(const tl_image *image, double x, double y, double half) {
  marker_window window = {clamped(floor(x - half), image->width), clamped(floor(y - half), image->height),
                          clamped(floor(x + half) + 2.0, image->width),
                          clamped(floor(y + half) + 2.0, image->height)};
  return window;
}

/* ---- colours ------------------------------------------------------------- */

/* hue 0..360, saturation and value 0..1 of channels 0..255 */
static void hsv(double b, double g, double r, double out[3]) {
  const double high = b > g ? (b > r ? b : r) : (g > r ? g : r);
  const double low = b < g ? (b < r ? b : r) : (g < r ? g : r);
  const double range = high - low;
  double sixth = 0.0;
  if (range > 0.0) {
    if (high == r)
      sixth = (g - b) / range;
    else
      sixth = high == g ? 2.0 + (b - r) / range : 4.0 + (r - g) / range;
  }
  out[0] = 60.0 * (sixth < 0.0 ? sixth + 6.0 : sixth);
  out[1] = high > 0.0 ? range / high : 0.0;
  out[2] = high / 255.0;
}

static double hue_apart(double a, double b) {
  const double apart = fabs(a - b);
  return apart > 180.0 ? 360.0 - apart : apart;
}

static int class_of(const double pixel[3], const tl_marker_color *color, int colors) {
  int found = 0;
  double nearest = 360.0;
  for (int c = 0; c < colors; c++) {
    const double apart = hue_apart(pixel[0], color[c].hue_deg);
    if (apart > color[c].hue_tolerance_deg || apart >= nearest) continue;
    if (pixel[1] < color[c].min_saturation || pixel[2] < color[c].min_value) continue;
    nearest = apart;
    found = c + 1;
  }
  return found;
}

static int color_sound(const tl_marker_color *c) {
  return c->hue_deg >= 0.0 && c->hue_deg <= 360.0 && c->hue_tolerance_deg > 0.0 &&
         c->hue_tolerance_deg < 90.0 && c->min_saturation > 0.0 && c->min_saturation <= 1.0 &&
         c->min_value >= 0.0 && c->min_value <= 1.0;
}

tl_status tl_marker_classes_init(tl_marker_classes *classes, const tl_marker_color *color, int colors) {
  double pixel[3];
  if (!classes || !color || colors < 1 || colors > TL_MARKER_MAX) return TL_ERR_ARGUMENT;
  for (int c = 0; c < colors; c++)
    if (!color_sound(&color[c])) return TL_ERR_RANGE;
  for (int cell = 0; cell < TL_MARKER_CLASS_CELLS; cell++) {
    /* the middle of the cell's 8 levels */
    hsv((cell >> 10) * 8 + 3.5, (cell >> 5 & 31) * 8 + 3.5, (cell & 31) * 8 + 3.5, pixel);
    classes->of[cell] = (uint8_t)class_of(pixel, color, colors);
  }
  return TL_OK;
}

/* ---- setup ---------------------------------------------------------------- */

static int links_sound(const tl_marker_setup *setup) {
  if (setup->links < 0 || setup->links > 2) return 0;
  for (int k = 0; k < setup->links; k++)
    for (int end = 0; end < 2; end++)
      if (setup->link[k][end] < 0 || setup->link[k][end] >= setup->markers) return 0;
  return 1;
}

tl_status tl_marker_start(const tl_marker_setup *setup, tl_marker_state *state) {
  if (!setup || !state || setup->markers < 1 || setup->markers > TL_MARKER_MAX) return TL_ERR_ARGUMENT;
  if (setup->colors < 1 || setup->colors > TL_MARKER_MAX || !links_sound(setup)) return TL_ERR_ARGUMENT;
  for (int m = 0; m < setup->markers; m++) {
    if (setup->color_of[m] < 0 || setup->color_of[m] >= setup->colors) return TL_ERR_ARGUMENT;
    if (!(setup->radius_px[m] >= 1.5 && setup->radius_px[m] <= 500.0)) return TL_ERR_RANGE;
    if (!(fabs(setup->start_px[m][0]) < 1e6 && fabs(setup->start_px[m][1]) < 1e6)) return TL_ERR_RANGE;
  }
  memset(state, 0, sizeof *state);
  return TL_OK;
}
