/* model_file.h: a model as YAML, read with every rule checked and written so that it reads back
 * to the same doubles.
 *
 *     struct model_file file;
 *     if (model_file_read(path, &file, &error) != 0) return app_exit(&error);
 *     file.model.mass_kg = ...;
 *     if (model_file_write(out_path, &file, "identified from walk.csv", &error) != 0) ...
 *
 * The keys are those of models/leg.yaml, models/pendulum.yaml and models/slider.yaml. Besides the
 * plant's own a model may have
 *
 *     form: lagrange                 # or paper (leg only)
 *     score: {lowpass_hz: 30, order: 4, standstill: 0.008, guard_s: 0.016, trim_s: 0.25}
 *                                    # any part of it; the rest keeps its default
 *     signal: {order: 5, window_s: 0.04}
 *                                    # window of the angles' reconstruction; absent: from the data
 *     bounds:                        # of the parameters that identification moves: [lower, upper]
 *       knee.friction.coulomb_Nm: [0, 10]   # by its key in this file,
 *       shank_com_m: [0.05, 0.3]            # or by its name in the report
 *     effects:                       # modelled effects; names and parameters: tl_effect_table
 *       - {effect: stribeck, joint: ankle,
 *          parameters: {extra_Nm: 0.4, speed_rad_s: 0.1, exponent: 2}}
 *     bus:                           # leg only: what models/leg.dbc cannot say (docs/bus.md)
 *       knee:                        # and ankle
 *         motor: {counts_per_turn: 16384, sign: 1}                      # relative encoder
 *         joint: {counts_per_turn: 65536, sign: 1, zero_count: 31250}   # absolute one
 *         current: {sign: 1}
 *
 * A bound lies within the parameter's physical range and holds the file's own value; equal bounds
 * keep the parameter where it is.
 */
#ifndef MODEL_FILE_H
#define MODEL_FILE_H

#include "common/error.h"
#include "talus/experimental/effect.h"
#include "talus/plant.h"
#include "talus/score.h"
#include "talus/signal.h"

#define MODEL_MAX_EFFECTS 8

/* How a drive of the leg counts. A sign of -1: it counts up where the model's angle or current falls. */
struct model_bus_joint {
  int motor_counts_per_turn, motor_sign;
  int joint_counts_per_turn, joint_sign;
  double joint_zero_count; /* at joint angle 0, within a turn */
  int current_sign;
};

struct model_bus {
  struct model_bus_joint joint[TL_MAX_JOINTS];
};

struct model_file {
  tl_model model;
  tl_score_settings score; /* the defaults where the file says nothing */
  int has_score;           /* the file has a `score:` */
  tl_window window;        /* when has_window */
  int has_window;          /* the file has a `signal:` */
  struct model_bus bus;    /* when has_bus */
  int has_bus;             /* the file has a `bus:` */
  /* in the order of tl_parameters: is there a bound, and which */
  int bounded[TL_MAX_PARAMETERS];
  double lower[TL_MAX_PARAMETERS], upper[TL_MAX_PARAMETERS];
  tl_effect effect[MODEL_MAX_EFFECTS];
  int effects;
};

/* "knee", ..., or "base": where an effect of this model stands. */
const char *model_effect_joint(const tl_model *m, int joint);

/* 0, or -1 with status 2 and a text that names file, line and key. *file is untouched then. */
int model_file_read(const char *path, struct model_file *file, struct app_error *error);

/* Writes atomically (output.h), keys in the order of the examples. `comment` becomes the first
 * lines, one '#' before each; Nullable: comment. 0, or -1 with status 1. */
int model_file_write(const char *path, const struct model_file *file, const char *comment,
                     struct app_error *error);

#endif
