/* fit.h: identification of a model from recordings: the passes over the data. */
#ifndef FIT_H
#define FIT_H

#include "common/error.h"
#include "inputs.h"
#include "recording/scored.h"
#include "talus/identify.h"

struct fit_settings {
  tl_identify_settings identify;
  int threads;
  int huber; /* 1: Huber's loss instead of the square, by reweighting */
};

/* One joint's error over all recordings, of the model as given and as identified. */
struct fit_error {
  struct scored nominal, identified;
};

struct fit {
  tl_problem problem;
  tl_identify_result result;
  uint64_t evaluations;
  int widened; /* how often the default bounds had to grow */
  struct fit_error error[TL_MAX_JOINTS];
  int few_blocks;        /* 1: too little data for standard deviations */
  tl_readings *readings; /* while it runs */
};

/* One grid instant of one joint after the fit, for the picture: filtered measured torque
 * and the filtered predictions of the model as given and as identified. */
struct fit_instant {
  int recording, joint;
  double t_s, measured, nominal, identified;
  int kind; /* TL_ROW_... */
};
typedef void (*fit_trace)(const struct fit_instant *instant, void *context);

/* Identifies `model` from the recordings. `trace` is called in order of recording and time.
 * Nullable: trace. */
int fit_run(struct fit *fit, const tl_model *model, const struct fit_settings *settings,
            const struct inputs *in, fit_trace trace, void *context, struct app_error *error);

#endif
