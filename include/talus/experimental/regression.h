/* regression.h: from a block of a recording to scored regression rows, and to predictions.
 *
 * At every row of the recording stands the plant's regressor; through a short stop it is
 * bridged (the torque is continuous there, its parts are not). Fitting and scoring see it on
 * the even grid, through the score's low-pass, together with the measured torque; prediction
 * is the regressor times the base parameters, unfiltered. One code for all three.
 *
 *     tl_regression r;
 *     tl_regression_space space;
 *     if (tl_regression_init(&r, &model, recorded, &score, step_s) != TL_OK) return 1;
 *     r.sensing[0] = sensing; // of each joint, from tl_kinematics_window
 *     tl_regression_space_init(&space, &r, rows, grid, memory, stops, mask);
 *     while (next_block(&block, &span)) {
 *       if (tl_regression_block(&r, &block, &span, &space) != TL_OK) return 1;
 *       for (int j = 0; j < tl_joint_count(&model); j++) tl_rows_fold(&space.rows[j], NULL, scratch, &factor[j]);
 *     }
 */
#ifndef TALUS_REGRESSION_H
#define TALUS_REGRESSION_H

#include <stddef.h>
#include <stdint.h>

#include "talus/experimental/effect.h"
#include "talus/factor.h"
#include "talus/filter.h"
#include "talus/kinematics.h"
#include "talus/plant.h"
#include "talus/score.h"
#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Everything that is the same for all blocks of one recording. */
typedef struct tl_regression {
  tl_model model;
  tl_layout layout;
  tl_score_settings score;
  tl_sensing sensing[TL_MAX_JOINTS];
  tl_lowpass lowpass;
  double step_s;     /* median step of the recording */
  uint32_t recorded; /* set of TL_CHANNEL_BIT */
  /* effects that are modelled already, by tl_regression_set_effects. Nullable: effect when effects is 0. */
  const tl_effect *effect;
  int effects;
  double begin_s;                /* the recording's first instant, from which effects of time count */
  double delay_s[TL_MAX_JOINTS]; /* of each current behind the angles, by effects */
  double
      telemetry_delay_s[TL_MAX_JOINTS]; /* of currents and angles behind a sensor at the output, by effects */
  double torque_constant_error
      [TL_MAX_JOINTS]; /* the drive delivers 1 + this of what current and constant say, by effects */
  tl_channel temperature[TL_MAX_JOINTS]; /* that effects need; TL_CHANNEL_COUNT where they do not */
} tl_regression;

/* Layout and filter; the sensing is still to be filled. Errors of tl_layout_init and tl_lowpass_init. */
TL_CHECK tl_status tl_regression_init(tl_regression *r, const tl_model *m, uint32_t recorded,
                                      const tl_score_settings *score, double step_s);
/* Effects to count as known, which must outlive r: those that change time or linkage are made part of
 * r, the others add to what is known. TL_ERR_RANGE when the linkage does not close with them, TL_ERR_UNSUPPORTED
 * when an effect needs a temperature that was not recorded; r is untouched then. begin_s: the recording's first instant. */
TL_CHECK tl_status tl_regression_set_effects(tl_regression *r, const tl_effect *effect, int effects,
                                             double begin_s);
/* How much of a recording on each side a block must see beyond its own part
 * so that the result is the same however the recording is cut [s]. */
double tl_regression_margin_s(const tl_regression *r);

/* Where a block lies: its segment's first and last instant, and the part [begin_s, end_s) of
 * which it gives the rows (end_s = infinity for the segment's last). */
typedef struct tl_span {
  double segment_begin_s, segment_end_s;
  double begin_s, end_s;
} tl_span;

/* A row at grid instant k counts, lies near standstill, or at the trimmed end of a segment. */
enum { TL_ROW_SCORED = 1, TL_ROW_STANDSTILL = 2, TL_ROW_TRIMMED = 0 };

/* Scored rows of one joint, column-major: tl_rows_column. Columns 0..columns-1 belong to base parameters index[], the
 * next is the target (measured - known), the last the measured. */
typedef struct tl_rows {
  int columns;
  int index[TL_MAX_ROW];
  size_t n, stride;
  double begin_s; /* instant of row 0; row k is at begin_s + k step_s */
  double *x;
  uint8_t *kind; /* (n) */
} tl_rows;

/* The memory of one block's work; see tl_regression_space_init. */
typedef struct tl_regression_space {
  size_t capacity, grid;
  tl_track track;
  double *raw[TL_MAX_JOINTS]; /* regressor at the recording's rows: columns + known + effort, column-major */
  tl_rows rows[TL_MAX_JOINTS];
  double *work;
  size_t work_n;
} tl_regression_space;

/* Doubles that a space for blocks of `capacity` rows and `grid` grid instants takes. */
size_t tl_regression_memory(const tl_regression *r, size_t capacity, size_t grid);
/* Lay the space out: stops (joints * capacity), mask (joints * grid). */
void tl_regression_space_init(tl_regression_space *space, const tl_regression *r, size_t capacity,
                              size_t grid, double *memory, tl_stop *stops, uint8_t *mask);

/* Kinematics and regressor of a block at the recording's own rows (space->track, space->raw). */
TL_CHECK tl_status tl_regression_motion(const tl_regression *r, const tl_block *block,
                                        tl_regression_space *space);
/* The same, and then space->rows: on the grid, filtered, marked. */
TL_CHECK tl_status tl_regression_block(const tl_regression *r, const tl_block *block, const tl_span *span,
                                       tl_regression_space *space);
/* Columns of a segment's rows, column after column of s->n, as the rows of a joint's torque go through the regression (joint
 * -1: as an angle's): through its short stops, on the even grid from begin_s and low-passed, into `grid` instants of
 * each, one after the other. `column` is changed. */
void tl_regression_columns(const tl_regression *r, const tl_effect_segment *s, int joint, double begin_s,
                           double *column, size_t columns, double *out, size_t grid);
/* After either: what the model with these base parameters predicts at row i of the block for `joint`. */
double tl_regression_predict(const tl_regression_space *space, int joint, const double *base, size_t i);

/* Fold the scored rows into the joint's factor (of rows->columns columns), weight[k] on
 * row k. Uses the caller's scratch of (columns + 1) * n doubles. Nullable: weight (all 1). */
void tl_rows_fold(const tl_rows *rows, const double *weight, double *scratch, tl_factor *factor);
/* Column c of the rows, (n). */
double *tl_rows_column(const tl_rows *rows, int c);
/* What was measured at row k. */
double tl_rows_measured(const tl_rows *rows, size_t k);
/* Residual target - x base of row k. */
double tl_rows_residual(const tl_rows *rows, const double *base, size_t k);

#ifdef __cplusplus
}
#endif
#endif
