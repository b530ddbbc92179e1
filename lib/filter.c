/* filter.c: see talus/filter.h. */
#include "talus/filter.h"

#include <math.h>
#include <string.h>

#include "talus/math.h"

#define MAX_SECTIONS (TL_LOWPASS_MAX_ORDER / 2)
#define NO_FILTER_ABOVE 0.95 /* of the Nyquist frequency, as the scoring rule says */

#define LANES                                                                                                \
  4 /* series filtered side by side: each output waits for the one before, those of other series do not */

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

/* state of each section in each lane, transposed direct form II */
typedef struct cascade {
  double s1[MAX_SECTIONS][LANES], s2[MAX_SECTIONS][LANES];
} cascade;

/* the state that a constant input would have led to */
static void steady_state(const tl_lowpass *f, const double input[LANES], cascade *c) {
  int i, k;

  for (i = 0; i < f->sections; i++)
    for (k = 0; k < LANES; k++) {
      c->s2[i][k] = (f->b[i][2] - f->a[i][2]) * input[k];
      c->s1[i][k] = (f->b[i][1] - f->a[i][1]) * input[k] + c->s2[i][k];
    }
}

/* one value through all sections of the first lane */
static double advance(const tl_lowpass *f, cascade *c, double now) {
  int i;

  for (i = 0; i < f->sections; i++) {
    double y = f->b[i][0] * now + c->s1[i][0];
    c->s1[i][0] = f->b[i][1] * now - f->a[i][1] * y + c->s2[i][0];
    c->s2[i][0] = f->b[i][2] * now - f->a[i][2] * y;
    now = y;
  }
  return now;
}

/* n values of the first lane, from the first or from the last */
static void run_one(const tl_lowpass *f, cascade *state, double *x, size_t n, int backward) {
  const tl_lowpass filter = *f; /* x may be anywhere, and what it may overwrite would be read again */
  cascade c = *state;
  size_t i;

  for (i = 0; i < n && !backward; i++) x[i] = advance(&filter, &c, x[i]);
  for (i = n; i > 0 && backward; i--) x[i - 1] = advance(&filter, &c, x[i - 1]);
  *state = c;
}

/* one section over all lanes */
static void run_section(const double b[3], const double a[3], double s1[LANES], double s2[LANES],
                        double *const x[LANES], size_t n, int backward) {
  const double b0 = b[0], b1 = b[1], b2 = b[2], a1 = a[1], a2 = a[2];
  double first[LANES], second[LANES], in[LANES], y[LANES];
  size_t i;
  int k;

  memcpy(first, s1, sizeof first);
  memcpy(second, s2, sizeof second);
  for (i = 0; i < n; i++) {
    size_t at = backward ? n - 1 - i : i;
    for (k = 0; k < LANES; k++) in[k] = x[k][at];
    for (k = 0; k < LANES; k++) {
      y[k] = b0 * in[k] + first[k];
      first[k] = b1 * in[k] - a1 * y[k] + second[k];
      second[k] = b2 * in[k] - a2 * y[k];
    }
    for (k = 0; k < LANES; k++) x[k][at] = y[k];
  }
  memcpy(s1, first, sizeof first);
  memcpy(s2, second, sizeof second);
}

static void run(const tl_lowpass *f, cascade *c, double *const *x, size_t lanes, size_t n, int backward) {
  int i;

  if (lanes == 1) run_one(f, c, x[0], n, backward);
  for (i = 0; i < f->sections && lanes == LANES; i++)
    run_section(f->b[i], f->a[i], c->s1[i], c->s2[i], x, n, backward);
}

/* Forward and backward over one lane or all, with an odd extension: each series turned about its end values. */
static void filter_lanes(const tl_lowpass *f, double *const *x, size_t lanes, size_t n) {
  double pads[2][LANES][TL_LOWPASS_PAD], end[LANES] = {0.0}, *before[LANES], *after[LANES];
  size_t i, k, pad = n - 1 < TL_LOWPASS_PAD ? n - 1 : TL_LOWPASS_PAD;
  cascade c;

  for (k = 0; k < lanes; k++) {
    before[k] = pads[0][k];
    after[k] = pads[1][k];
    for (i = 0; i < pad; i++) {
      before[k][i] = 2.0 * x[k][0] - x[k][pad - i];
      after[k][i] = 2.0 * x[k][n - 1] - x[k][n - 2 - i];
    }
    end[k] = pad ? before[k][0] : x[k][0];
  }
  steady_state(f, end, &c);
  run(f, &c, before, lanes, pad, 0);
  run(f, &c, x, lanes, n, 0);
  run(f, &c, after, lanes, pad, 0);
  /* what comes out before x[0] is not needed */
  for (k = 0; k < lanes; k++) end[k] = pad ? after[k][pad - 1] : x[k][n - 1];
  steady_state(f, end, &c);
  run(f, &c, after, lanes, pad, 1);
  run(f, &c, x, lanes, n, 1);
}

void tl_lowpass_zero_phase_batch(const tl_lowpass *f, double *x, size_t n, size_t series) {
  double *lane[LANES];
  size_t begin, lanes, k;

  if (f->pass || n < 1) return;
  for (begin = 0; begin < series; begin += lanes) {
    lanes = series - begin < LANES ? 1 : LANES;
    for (k = 0; k < lanes; k++) lane[k] = x + (begin + k) * n;
    filter_lanes(f, lane, lanes, n);
  }
}

void tl_lowpass_zero_phase(const tl_lowpass *f, double *x, size_t n) {
  tl_lowpass_zero_phase_batch(f, x, n, 1);
}
