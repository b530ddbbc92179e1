/* twin.h: one run of the bench twin, from a model file to a recording and its truth. */
#ifndef TWIN_H
#define TWIN_H

#include <stdint.h>

#include "common/error.h"
#include "model/model_file.h"
#include "motion/trajectory.h"
#include "talus/experimental/excitation.h"
#include "talus/experimental/twin.h"

/* TWIN_BUS: set-points from the bus */
enum twin_excitation { TWIN_MULTISINE, TWIN_PAPER, TWIN_RAMPS, TWIN_BUS, TWIN_REFERENCE };

/* What a run is asked for. A NaN stands for the default of plant and excitation. */
struct twin_settings {
  const char *model, *out;    /* paths */
  const char *truth, *motion; /* paths, NULL: not written */
  const char *can;            /* interface to run on in real time, NULL: none */
  const char *reference;      /* trajectory to follow, NULL: none */
  enum twin_excitation excitation;
  double period_s;                 /* of the series */
  int harmonics;                   /* of the multisine, 0: default */
  double amplitude[TL_MAX_JOINTS]; /* of the multisine and the ramps */
  double speed;                    /* factor on the excitation's speed */
  const char *limits;              /* in place of the bench's (motion/limits.h), NULL: none */
  int fit;                         /* scale the excitation into the limits */
  double duration_s, rate_hz, jitter_s, control_hz;
  double drive_bits[TL_MAX_JOINTS], ankle_bits; /* 0: exact */
  double noise_A[TL_MAX_JOINTS];
  double camera_rad;   /* noise of the camera's angles */
  int camera;          /* record them */
  int ideal;           /* exact sensors: what is not given is 0 */
  uint64_t seed;       /* of noise and jitter */
  uint64_t phase_seed; /* of the multisine's phases */
};

/* All defaults; the paths are to be filled in. */
struct twin_settings twin_defaults(void);

/* What a run on the bus was like. */
struct twin_live {
  int64_t begin_real_ns;       /* CLOCK_REALTIME at the first tick's deadline */
  unsigned long ticks, late;   /* late: by more than a period */
  double worst_s;              /* lateness */
  unsigned long sent, refused; /* frames; refused: the kernel did not take them */
  unsigned long setpoints, missed;
  double zero_count[TL_MAX_JOINTS]; /* of the relative encoders at joint angle 0 */
};

/* A run that is ready to start. */
struct twin {
  const struct twin_settings *asked;
  tl_model model;
  tl_effect effect[MODEL_MAX_EFFECTS]; /* the model's */
  int effects;
  tl_excitation excitation;
  struct trajectory trajectory; /* when it is followed */
  tl_scaling scaling;
  tl_limits limits[TL_MAX_JOINTS];
  tl_twin_settings bench;
  double duration_s;
  struct model_bus bus; /* when has_bus */
  int has_bus;
  struct twin_live live; /* after a run on the bus */
};

/* Reads the model and checks the excitation: 0, or -1 with status 2, naming every limit that
 * would be broken. `settings` is kept by reference. */
int twin_prepare(struct twin *twin, const struct twin_settings *settings, struct app_error *error);
/* Runs it and writes what was asked for. 0, or -1. */
int twin_run(struct twin *twin, struct app_error *error);
/* Whether twin_prepare succeeded or not. */
void twin_free(struct twin *twin);

#endif
