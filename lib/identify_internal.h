/* identify_internal.h: what identify_conclude.c and identify_readings.c share. */
#ifndef IDENTIFY_INTERNAL_H
#define IDENTIFY_INTERNAL_H

#include "talus/identify.h"

/* Change of the parameters and of the base parameters when the summed products of row and residual change by one, at the
 * result's values: gain is (parameters, bases), base_gain (bases, bases). kept: directions that the data see. */
typedef struct tl_gain {
  double parameter[TL_MAX_PARAMETERS * TL_MAX_BASE];
  double base[TL_MAX_BASE * TL_MAX_BASE];
  int kept;
} tl_gain;

TL_CHECK tl_status tl_identify_gain(const tl_problem *problem, const double *value, tl_gain *gain);

#endif
