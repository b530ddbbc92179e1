/* scored.h: how far a prediction is off at one joint, summed over the rows that the score counts (talus/score.h).
 *
 *     struct scored knee = {0};
 *     for each row: scored_add(&knee, kind, measured, residual);
 *     scored_relative_percent(&knee)   // 100 |residual| / |measured|
 *
 * Figures are NaN where there is nothing to score; in [N m], or [N] for a slider.
 */
#ifndef SCORED_H
#define SCORED_H

#include <stddef.h>

#include "talus/plant.h"

struct scored {
  double residual, measured; /* sums of squares over scored rows */
  double reversal;           /* of the residual on rows that are left out near standstill */
  size_t rows, left_out;
};

/* One row: `kind` is TL_ROW_..., the residual measured - predicted; both behind the score's low-pass. */
void scored_add(struct scored *s, int kind, double measured, double residual);

double scored_rms(const struct scored *s);
double scored_measured_rms(const struct scored *s);
double scored_relative_percent(const struct scored *s);
double scored_reversal_rms(const struct scored *s);

/* "Nm" or "N"; "torque" or "force". */
const char *scored_unit(const tl_model *model);
const char *scored_quantity(const tl_model *model);

/* "Error 5.3 % of the measured torque at the knee and 2.1 % at the ankle." from one entry a joint; or that nothing moves
 * enough to be scored. */
void scored_sentence(char *text, size_t size, const struct scored *const *joint, const tl_model *model);

#endif
