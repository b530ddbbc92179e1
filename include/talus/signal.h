/* signal.h: derivatives of a sampled angle by sliding Legendre windows.
 *
 * Around each sample a polynomial is fitted by least squares to the samples
 * within the window, at their true times; its value and derivatives at the
 * sample are the reconstruction. Near the ends of the data the window stays
 * inside and the polynomial is read off its centre.
 *
 *     tl_window w = {.order = 4, .length_s = 0.04};
 *     double work[2000]; // tl_reconstruct_workspace: of the samples in a window
 *     if (tl_reconstruct(&w, t_s, angle_rad, n, q, v, a, work, 2000) != TL_OK) return 1;
 *     printf("%.2f rad/s, %.1f rad/s^2\n", v[100], a[100]); // prints 1.20 rad/s, 3.0 rad/s^2
 */
#ifndef TALUS_SIGNAL_H
#define TALUS_SIGNAL_H

#include <stddef.h>

#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_WINDOW_MAX_ORDER 24
#define TL_WINDOW_MAX_SAMPLES 4096

typedef struct tl_window {
  int order;       /* of the polynomial, 2..TL_WINDOW_MAX_ORDER */
  double length_s; /* whole length of the window; at least order + 1 samples are used in any case */
} tl_window;

/* Doubles of workspace that tl_reconstruct needs when no window holds more
 * than `samples` samples. */
size_t tl_reconstruct_workspace(size_t samples);
/* One window: least-squares polynomial of `order` through (t_s, x) (n samples),
 * value, first and second derivative at `at_s` in out[]. By polynomials that
 * are orthogonal on the given samples (Forsythe 1957), O(n order).
 * `work` holds 3 n doubles. TL_ERR_TOO_SHORT when n <= order. */
TL_CHECK tl_status tl_window_fit(const double *t_s, const double *x, size_t n, double at_s, int order,
                                 double *work, double out[3]);
/* The same window as weights on its samples, whatever these are: weight[d * n + i] is sample
 * i's in value (d = 0), first (1) and second derivative (2). `work` holds 3 n doubles. */
TL_CHECK tl_status tl_window_weights(const double *t_s, size_t n, double at_s, int order, double *work,
                                     double *weight);
/* Position, velocity and acceleration at each of n samples; times rise
 * strictly. Any output may be NULL. Runs of evenly spaced samples (to 1e-6 of
 * the step) take a fixed kernel, others a fit at their true times.
 * Nullable: position, velocity, acceleration. */
TL_CHECK tl_status tl_reconstruct(const tl_window *w, const double *t_s, const double *x, size_t n,
                                  double *position, double *velocity, double *acceleration, double *work,
                                  size_t work_n);

#ifdef __cplusplus
}
#endif
#endif
