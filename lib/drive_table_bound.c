/* drive_table_bound.c: a proof that a table is as good as it says.
 *
 * A cubic Hermite table errs by at most step^4 / 384 times the largest fourth derivative of its function (de Boor
 * 1978). The derivatives are enclosed: Taylor coefficients (Moore 1966) in interval arithmetic over pieces of each step,
 * from the closed form of the linkage or from the series. Rounding of the intervals' ends, some units of 2^-53, is covered
 * by widening the result by 1e-9 of itself.
 */
#include "drive_table_bound.h"

#include <math.h>

#include "talus/math.h"

#define ORDER 5  /* the ratio's fourth derivative is the angle's fifth */
#define PIECES 8 /* of a step: narrow intervals enclose better */
#define WIDENED (1.0 + 1e-9)

/* an interval, and Taylor coefficients f^(k) / k! over an interval of the argument */
typedef struct range {
  double low, high;
} range;
typedef struct taylor {
  range c[ORDER + 1];
} taylor;

static range point(double x) {
  return (range){x, x};
}

static range add(range a, range b) {
  return (range){a.low + b.low, a.high + b.high};
}

static range negative(range a) {
  return (range){-a.high, -a.low};
}

static range times(range a, range b) {
  double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;

  return (range){smaller(smaller(p, q), smaller(r, s)), larger(larger(p, q), larger(r, s))};
}

/* 1 / a; everything where a may be 0 */
static range reciprocal(range a) {
  if (a.low > 0.0 || a.high < 0.0) return (range){1.0 / a.high, 1.0 / a.low};
  return (range){-HUGE_VAL, HUGE_VAL};
}

static range scaled(range a, double s) {
  return times(a, point(s));
}

static double size(range a) {
  return larger(fabs(a.low), fabs(a.high));
}

/* coefficients of sin(w x + shift): derivatives go round in four; over middle +- half a value moves by at most w half */
static taylor sine(double w, double shift, double middle, double half) {
  double at = w * middle + shift, value[4], factor = 1.0;
  taylor t;
  int k;

  value[0] = tl_sin(at);
  value[1] = tl_cos(at);
  value[2] = -value[0];
  value[3] = -value[1];
  for (k = 0; k <= ORDER; k++) {
    double reach = fabs(w) * half;
    range here = {larger(value[k % 4] - reach, -1.0), smaller(value[k % 4] + reach, 1.0)};

    t.c[k] = scaled(here, factor);
    factor *= w / (double)(k + 1);
  }
  return t;
}

static taylor product(const taylor *a, const taylor *b) {
  taylor t;
  int i, k;

  for (k = 0; k <= ORDER; k++) {
    t.c[k] = times(a->c[0], b->c[k]);
    for (i = 1; i <= k; i++) t.c[k] = add(t.c[k], times(a->c[i], b->c[k - i]));
  }
  return t;
}

/* s s = g: s0 = sqrt(g0), 2 s0 s_k = g_k - sum of s_i s_(k-i), i = 1..k-1 */
static taylor root(const taylor *g) {
  taylor s;
  range half;
  int i, k;

  s.c[0] = (range){sqrt(larger(g->c[0].low, 0.0)), sqrt(larger(g->c[0].high, 0.0))};
  half = reciprocal(scaled(s.c[0], 2.0));
  for (k = 1; k <= ORDER; k++) {
    range left = g->c[k];
    for (i = 1; i < k; i++) left = add(left, negative(times(s.c[i], s.c[k - i])));
    s.c[k] = times(left, half);
  }
  return s;
}

/* r k = 1: r0 = 1 / k0, r_n = -(sum of k_i r_(n-i), i = 1..n) / k0 */
static taylor inverse(const taylor *k) {
  taylor r;
  int i, n;

  r.c[0] = reciprocal(k->c[0]);
  for (n = 1; n < ORDER; n++) {
    range sum = point(0.0);
    for (i = 1; i <= n; i++) sum = add(sum, times(k->c[i], r.c[n - i]));
    r.c[n] = times(negative(sum), r.c[0]);
  }
  r.c[ORDER] = point(0.0);
  return r;
}

/* CO = BO cos(phi) + sqrt(AB^2 - (AC - BO sin phi)^2), phi = phi0 - q; times 2 pi / lead */
static taylor linkage(const tl_transmission *t, double middle, double half) {
  double BO = t->linkage.BO_m, AB = t->linkage.AB_m;
  taylor x = sine(1.0, 0.5 * TL_PI - t->phi0_rad, middle, half); /* cos(phi0 - q) */
  taylor y = sine(-1.0, t->phi0_rad, middle, half), h, g, motor;
  int k;

  for (k = 0; k <= ORDER; k++) h.c[k] = scaled(y.c[k], -BO);
  h.c[0] = add(h.c[0], point(t->linkage.AC_m));
  g = product(&h, &h);
  for (k = 0; k <= ORDER; k++) g.c[k] = negative(g.c[k]);
  g.c[0] = add(g.c[0], point(AB * AB));
  h = root(&g);
  for (k = 0; k <= ORDER; k++) motor.c[k] = scaled(add(scaled(x.c[k], BO), h.c[k]), t->screw_rad_m);
  return motor;
}

/* a0 + sum of a_j cos(j omega q) + b_j sin(j omega q) */
static taylor series(const tl_fourier *f, double middle, double half) {
  taylor motor = {{{0.0, 0.0}}};
  int j, k;

  motor.c[0] = point(f->a[0]);
  for (j = 1; j <= TL_FOURIER_ORDER; j++) {
    double w = (double)j * f->omega;
    taylor s = sine(w, 0.0, middle, half), c = sine(w, 0.5 * TL_PI, middle, half);

    for (k = 0; k <= ORDER; k++)
      motor.c[k] = add(motor.c[k], add(scaled(c.c[k], f->a[j]), scaled(s.c[k], f->b[j - 1])));
  }
  return motor;
}

/* the largest fourth derivatives over a piece: angle, ratio, 1 / ratio */
static void derivatives(const tl_transmission *t, double middle, double half, double most[3]) {
  taylor motor =
      t->kind == TL_TRANSMISSION_FOURIER ? series(&t->fourier, middle, half) : linkage(t, middle, half);
  taylor ratio, per_ratio;
  int k;

  for (k = 0; k < ORDER; k++) ratio.c[k] = scaled(motor.c[k + 1], (double)(k + 1));
  ratio.c[ORDER] = point(0.0);
  per_ratio = inverse(&ratio);
  most[0] = larger(most[0], 24.0 * size(motor.c[4]));
  most[1] = larger(most[1], 24.0 * size(ratio.c[4]));
  most[2] = larger(most[2], 24.0 * size(per_ratio.c[4]));
}

void tl_drive_table_interpolation(const tl_transmission *t, double first, double step, int n,
                                  double bound[3]) {
  double most[3] = {0.0, 0.0, 0.0}, width = step / PIECES;
  int i;

  for (i = 0; i < (n - 1) * PIECES; i++)
    derivatives(t, first + ((double)i + 0.5) * width, 0.5 * width * WIDENED, most);
  for (i = 0; i < 3; i++) bound[i] = step * step * step * step / 384.0 * most[i] * WIDENED;
}
