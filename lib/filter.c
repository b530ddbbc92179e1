/* filter.c: see talus/filter.h. */
#include "talus/filter.h"

#include <math.h>

#include "talus/math.h"

#define MAX_SECTIONS (TL_LOWPASS_MAX_ORDER / 2)
#define NO_FILTER_ABOVE 0.95 /* of the Nyquist frequency, as the scoring rule says */

/* state of a cascade, transposed direct form II */
typedef struct cascade {
  double s1[MAX_SECTIONS], s2[MAX_SECTIONS];
} cascade;

/* bilinear transform of 1 / (s^2 + s / q + 1), k = tan(pi cutoff step) */
static void pair_section(tl_lowpass *f, int i, double k, double inverse_q) {
  double d = 1.0 / (1.0 + k * inverse_q + k * k);

  f->b[i][0] = k * k * d;
  f->b[i][1] = 2.0 * k * k * d;
  f->b[i][2] = k * k * d;
  f->a[i][0] = 1.0;
  f->a[i][1] = 2.0 * (k * k - 1.0) * d;
  f->a[i][2] = (1.0 - k * inverse_q + k * k) * d;
}

/* bilinear transform of 1 / (s + 1) */
static void single_section(tl_lowpass *f, int i, double k) {
  f->b[i][0] = f->b[i][1] = k / (1.0 + k);
  f->b[i][2] = 0.0;
  f->a[i][0] = 1.0;
  f->a[i][1] = (k - 1.0) / (k + 1.0);
  f->a[i][2] = 0.0;
}

/* samples until the slowest pole has decayed to 1e-17 */
static size_t settling(const tl_lowpass *f) {
  double slowest = 0.0, samples;
  int i;

  for (i = 0; i < f->sections; i++) {
    double radius = f->a[i][2] > 0.0 ? sqrt(f->a[i][2]) : fabs(f->a[i][1]);
    slowest = radius > slowest ? radius : slowest;
  }
  if (slowest <= 0.0) return 1;
  samples = -39.2 / tl_log(slowest);
  return samples < 1e9 ? (size_t)samples + 1 : (size_t)1000000000;
}

tl_status tl_lowpass_init(tl_lowpass *f, int order, double cutoff_hz, double step_s) {
  double k;
  int i;

  if (!f || order < 1 || order > TL_LOWPASS_MAX_ORDER) return TL_ERR_ARGUMENT;
  if (!(cutoff_hz > 0.0) || !(step_s > 0.0)) return TL_ERR_RANGE;
  f->sections = 0;
  f->settling = 0;
  f->pass = 2.0 * cutoff_hz * step_s >= NO_FILTER_ABOVE;
  if (f->pass) return TL_OK;
  k = tl_tan(TL_PI * cutoff_hz * step_s);
  for (i = 0; i < order / 2; i++) {
    /* pole pair at the angle theta from the negative real axis: 1 / q = 2 cos theta */
    double theta = TL_PI * (order - 1 - 2 * i) / (2.0 * order);
    pair_section(f, i, k, 2.0 * tl_cos(theta));
  }
  if (order % 2) single_section(f, i++, k);
  f->sections = i;
  f->settling = settling(f);
  return TL_OK;
}

/* the state that a constant input would have led to */
static void steady_state(const tl_lowpass *f, double input, cascade *c) {
  int i;

  for (i = 0; i < f->sections; i++) {
    c->s2[i] = (f->b[i][2] - f->a[i][2]) * input;
    c->s1[i] = (f->b[i][1] - f->a[i][1]) * input + c->s2[i];
  }
}

static double advance(const tl_lowpass *f, cascade *c, double x) {
  int i;

  for (i = 0; i < f->sections; i++) {
    double y = f->b[i][0] * x + c->s1[i];
    c->s1[i] = f->b[i][1] * x - f->a[i][1] * y + c->s2[i];
    c->s2[i] = f->b[i][2] * x - f->a[i][2] * y;
    x = y;
  }
  return x;
}

void tl_lowpass_zero_phase(const tl_lowpass *f, double *x, size_t n) {
  double before[TL_LOWPASS_PAD], after[TL_LOWPASS_PAD], last;
  size_t i, pad;
  cascade c;

  if (f->pass || n < 1) return;
  pad = n - 1 < TL_LOWPASS_PAD ? n - 1 : TL_LOWPASS_PAD;
  /* odd extension: the series turned about its end values */
  for (i = 0; i < pad; i++) {
    before[i] = 2.0 * x[0] - x[pad - i];
    after[i] = 2.0 * x[n - 1] - x[n - 2 - i];
  }
  /* forward ... */
  steady_state(f, pad ? before[0] : x[0], &c);
  for (i = 0; i < pad; i++) before[i] = advance(f, &c, before[i]);
  for (i = 0; i < n; i++) x[i] = advance(f, &c, x[i]);
  for (i = 0; i < pad; i++) after[i] = advance(f, &c, after[i]);
  /* ... and backward; what comes out before x[0] is not needed */
  last = pad ? after[pad - 1] : x[n - 1];
  steady_state(f, last, &c);
  for (i = pad; i > 0; i--) advance(f, &c, after[i - 1]);
  for (i = n; i > 0; i--) x[i - 1] = advance(f, &c, x[i - 1]);
}
