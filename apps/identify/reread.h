/* reread.h: the recordings read once more in every way that tl_identify_readings asks for. */
#ifndef REREAD_H
#define REREAD_H

#include "fold.h"
#include "inputs.h"

/* Fills `readings`, of excerpts where these are a fair picture of long recordings; `f` is emptied and used, without Huber's
 * weights. */
int reread_all(tl_readings *readings, struct folding *f, const tl_problem *problem, const struct inputs *in,
               struct app_error *error);

#endif
