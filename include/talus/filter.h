/* filter.h: zero-phase Butterworth low-pass, as the score uses it.
 *
 *     double x[500]; // 2 s: 1 with a ripple of 125 Hz
 *     for (int k = 0; k < 500; k++) x[k] = k % 2 ? 1.1 : 0.9;
 *     tl_lowpass f;
 *     if (tl_lowpass_init(&f, 4, 30.0, 0.004) != TL_OK) return 1;
 *     tl_lowpass_zero_phase(&f, x, 500);
 *     printf("%.4f\n", x[250]); // prints 1.0000
 */
#ifndef TALUS_FILTER_H
#define TALUS_FILTER_H

#include <stddef.h>

#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_LOWPASS_MAX_ORDER 8
#define TL_LOWPASS_PAD 60 /* samples of odd extension at each end, as scipy's filtfilt with padlen 60 */

/* A cascade of second-order sections; `pass` set means: does nothing. */
typedef struct tl_lowpass {
  int sections;
  int pass;
  double b[TL_LOWPASS_MAX_ORDER / 2][3];
  double a[TL_LOWPASS_MAX_ORDER / 2][3];
  size_t settling; /* samples until the slowest pole has decayed to 1e-17 */
} tl_lowpass;

/* Bilinear Butterworth of `order` 1..8 at cutoff_hz for samples each step_s.
 * When 2 cutoff step >= 0.95 (near or above Nyquist) the filter passes all. */
TL_CHECK tl_status tl_lowpass_init(tl_lowpass *f, int order, double cutoff_hz, double step_s);
/* Forward and backward in place over n samples, each section started at the
 * steady state of its first input, odd extension of min(n - 1, 60) samples
 * (Gustafsson 1996 discusses the choice). n >= 1. */
void tl_lowpass_zero_phase(const tl_lowpass *f, double *x, size_t n);
/* The same for `series` series of n, one after the other: as if each had been filtered alone, and faster. */
void tl_lowpass_zero_phase_batch(const tl_lowpass *f, double *x, size_t n, size_t series);

#ifdef __cplusplus
}
#endif
#endif
