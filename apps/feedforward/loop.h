/* loop.h: the closed loop on a CAN bus, at absolute instants, recorded as talus-acquire does: talus-feedforward --can. */
#ifndef LOOP_H
#define LOOP_H

#include "acquire/record/session.h"
#include "controller/controller_options.h"

#define LOOP_REST_S 1.0 /* on the first row and on the last */

struct loop_settings {
  const char *model, *can;
  const char *estop; /* NAME=CHIP:LINE[:EDGES], NULL: none */
  double speed_lag_s;
  struct controller_options drives;
  struct session_settings session; /* out, play, limits and how to record; the rest is filled in */
};

/* 0, or -1: bad input, nothing was sent then; or something was lost, late or refused. */
int loop_run(struct loop_settings *settings, struct app_error *error);

#endif
