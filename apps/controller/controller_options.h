/* controller_options.h: a controller from a model file and the options that say what its drives may do.
 *
 *     static struct controller_options asked = CONTROLLER_DEFAULTS;
 *     static const struct cli_option options[] = {..., CONTROLLER_OPTIONS(asked)};
 *     ...
 *     static struct controller made;
 *     if (controller_make(&file, path, &asked, &made, &error) != 0) return app_exit(&error);
 *     tl_controller_tick_f64(&made.f64, &state, &in, &out);
 */
#ifndef CONTROLLER_OPTIONS_H
#define CONTROLLER_OPTIONS_H

#include "common/cli.h"
#include "common/error.h"
#include "model/model_file.h"
#include "talus/experimental/controller_prepare.h"

struct controller_options {
  double tick_s, current_A[2], power_W[2], low_rad[2], high_rad[2], fade_rad, friction_share;
};

#define CONTROLLER_DEFAULTS                                                                                  \
  {                                                                                                          \
    .tick_s = 1e-3, .current_A = {20.0, 20.0}, .power_W = {200.0, 200.0},                                    \
    .low_rad = {-2.0, -TL_JOINT_RANGE_RAD}, .high_rad = {2.0, TL_JOINT_RANGE_RAD}, .fade_rad = 0.05,         \
    .friction_share = 1.0                                                                                    \
  }

/* rows of a program's table of options; of `asked`, a struct controller_options */
#define CONTROLLER_OPTIONS(asked)                                                                              \
  {"knee-current",                                                                                             \
   0,                                                                                                          \
   CLI_NUMBER,                                                                                                 \
   &(asked).current_A[0],                                                                                      \
   0,                                                                                                          \
   "A",                                                                                                        \
   "peak current of the knee's drive (default 20)"},                                                           \
      {"ankle-current", 0, CLI_NUMBER, &(asked).current_A[1], 0, "A", "of the ankle's (default 20)"},          \
      {"knee-power",                                                                                           \
       0,                                                                                                      \
       CLI_NUMBER,                                                                                             \
       &(asked).power_W[0],                                                                                    \
       0,                                                                                                      \
       "W",                                                                                                    \
       "peak mechanical power of the knee's motor (default 200)"},                                             \
      {"ankle-power", 0, CLI_NUMBER, &(asked).power_W[1], 0, "W", "of the ankle's (default 200)"},             \
      {"knee-low", 0, CLI_NUMBER, &(asked).low_rad[0], 0, "RAD", "the knee's lower stop (default -2)"},        \
      {"knee-high", 0, CLI_NUMBER, &(asked).high_rad[0], 0, "RAD", "its upper stop (default 2)"},              \
      {"ankle-low", 0, CLI_NUMBER, &(asked).low_rad[1], 0, "RAD", "the ankle's lower stop (default -0.5236)"}, \
      {"ankle-high", 0, CLI_NUMBER, &(asked).high_rad[1], 0, "RAD", "its upper stop (default 0.5236)"},        \
      {"fade",                                                                                                 \
       0,                                                                                                      \
       CLI_NUMBER,                                                                                             \
       &(asked).fade_rad,                                                                                      \
       0,                                                                                                      \
       "RAD",                                                                                                  \
       "torque towards a stop fades over this way (default 0.05)"},                                            \
  {                                                                                                            \
    "friction-share", 0, CLI_NUMBER, &(asked).friction_share, 0, "X",                                          \
        "of the model's friction that is compensated (default 1)"                                              \
  }

/* Not to be copied: the curves point into it. */
struct controller {
  tl_controller_settings settings;
  tl_controller_f64 f64;
  tl_curve_knot_f64 knot[TL_CONTROLLER_KNOTS];
};

/* 0, or -1 with status 2: an effect that has no fast form, by name, another plant, a number out of range. `path` is what
 * the error calls the model. */
int controller_make(const struct model_file *file, const char *path, const struct controller_options *asked,
                    struct controller *made, struct app_error *error);

#endif
