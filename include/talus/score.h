/* score.h: how an error is scored; one definition for every command.
 *
 * Measured and predicted are put on an even grid (the median step), segment by
 * segment, pass the same zero-phase low-pass, and samples near standstill and
 * at the ends of a segment are left out (and reported apart).
 *
 *     tl_score_settings s = tl_score_defaults();
 *     tl_score_result r;
 *     if (tl_score(&s, t_s, NULL, measured_Nm, predicted_Nm, speed_rad_s, n, work, work_n, &r) != TL_OK) return 1;
 *     printf("%.1f %%\n", r.relative_percent); // prints 5.0 %
 */
#ifndef TALUS_SCORE_H
#define TALUS_SCORE_H

#include <stddef.h>
#include <stdint.h>

#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_GAP_STEPS 5.0       /* a step of more than this many median steps cuts a segment */
#define TL_SEGMENT_MIN_ROWS 21 /* shorter segments are not scored */

/* The model file's `score:`. */
typedef struct tl_score_settings {
  double lowpass_hz; /* 30 */
  int order;         /* 4 */
  double standstill; /* 0.008 rad/s or m/s */
  double guard_s;    /* 0.016 */
  double trim_s;     /* 0.25 */
} tl_score_settings;

tl_score_settings tl_score_defaults(void);

/* Rows [begin, end) of a recording without gap or change of `valid`. */
typedef struct tl_segment {
  size_t begin, end;
} tl_segment;

/* Median of the n - 1 steps of t_s; `work` holds n - 1 doubles. n >= 2. */
double tl_median_step(const double *t_s, size_t n, double *work);

/* Does a new segment begin at a row whose time and validity follow these? */
int tl_segment_cut(double previous_s, double time_s, int previous_valid, int valid, double step_s);
/* The next usable segment (valid, longer than 20 rows) from row *cursor on, which moves
 * behind it: 1, or 0 when there is none left. Nullable: valid (all rows count). */
int tl_segment_next(const double *t_s, const uint8_t *valid, size_t n, double step_s, size_t *cursor,
                    tl_segment *out);

/* The even grid of a segment: instants begin_s + k step_s, k = 0..count-1, all before end_s. */
size_t tl_grid_count(double begin_s, double end_s, double step_s);
/* Linear interpolation of (t_s, x) (n rows) at m grid instants begin_s + k step_s;
 * times outside hold the end values. */
void tl_grid_resample(const double *t_s, const double *x, size_t n, double begin_s, double step_s,
                      double *out, size_t m);
/* The same for `series` series of n, one after the other; m instants of each, one after the other. */
void tl_grid_resample_batch(const double *t_s, const double *x, size_t n, size_t series, double begin_s,
                            double step_s, double *out, size_t m);
/* keep[k] = 1 unless |speed| < standstill within guard_s of grid instant k (m of them). */
void tl_score_keep(const tl_score_settings *s, const double *speed, size_t m, double step_s, uint8_t *keep);

typedef struct tl_score_result {
  double residual_rms, measured_rms, relative_percent;
  double reversal_rms; /* of the residual on the samples left out at standstill; 0 if none */
  size_t scored, left_out;
} tl_score_result;

/* Score a whole recording held in memory. speed is the |joint velocity| at each row.
 * Nullable: valid. TL_ERR_TOO_SHORT when no sample remains. */
size_t tl_score_workspace(size_t n);
TL_CHECK tl_status tl_score(const tl_score_settings *s, const double *t_s, const uint8_t *valid,
                            const double *measured, const double *predicted, const double *speed, size_t n,
                            double *work, size_t work_n, tl_score_result *out);

#ifdef __cplusplus
}
#endif
#endif
