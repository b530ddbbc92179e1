/* reread.h: the recordings read once more in every way that tl_identify_readings asks for. */
#ifndef REREAD_H
#define REREAD_H

#include "fit.h"
#include "fold.h"

/* Fills `readings`; `f` is emptied and used, without Huber's weights. */
int reread_all(tl_readings *readings, struct folding *f, const tl_problem *problem, const tl_model *model,
               const struct fit_input *in, struct app_error *error);

#endif
