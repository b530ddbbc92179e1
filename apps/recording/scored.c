/* scored.c: see scored.h. */
#include "scored.h"

#include <math.h>
#include <stdio.h>

#include "talus/experimental/regression.h"

void scored_add(struct scored *s, int kind, double measured, double residual) {
  if (kind == TL_ROW_SCORED) {
    s->residual += residual * residual;
    s->measured += measured * measured;
    s->rows++;
  } else if (kind == TL_ROW_STANDSTILL) {
    s->reversal += residual * residual;
    s->left_out++;
  }
}

static double rms(double sum_of_squares, size_t n) {
  return n ? sqrt(sum_of_squares / (double)n) : (double)NAN;
}

double scored_rms(const struct scored *s) {
  return rms(s->residual, s->rows);
}

double scored_measured_rms(const struct scored *s) {
  return rms(s->measured, s->rows);
}

double scored_relative_percent(const struct scored *s) {
  return s->measured > 0.0 ? 100.0 * sqrt(s->residual / s->measured) : (double)NAN;
}

double scored_reversal_rms(const struct scored *s) {
  return rms(s->reversal, s->left_out);
}

const char *scored_unit(const tl_model *model) {
  return tl_plant_facts(model->plant)->torque_unit;
}

const char *scored_quantity(const tl_model *model) {
  return tl_plant_facts(model->plant)->torque_name;
}

void scored_sentence(char *text, size_t size, const struct scored *const *joint, const tl_model *model) {
  int at = snprintf(text, size, "Error "), told = 0;

  for (int j = 0; j < tl_joint_count(model) && at < (int)size; j++) {
    if (joint[j]->rows == 0) continue;
    at += snprintf(text + at, size - (size_t)at, "%s%.1f %%", told ? " and " : "",
                   scored_relative_percent(joint[j]));
    if (!told++ && at < (int)size)
      at += snprintf(text + at, size - (size_t)at, " of the measured %s", scored_quantity(model));
    if (at < (int)size) at += snprintf(text + at, size - (size_t)at, " at the %s", tl_joint_name(model, j));
  }
  if (at < (int)size) snprintf(text + at, size - (size_t)at, ".");
  if (!told) snprintf(text, size, "No joint moves enough in these recordings to be scored.");
}
