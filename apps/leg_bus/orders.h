/* orders.h: what the bus asks of the twin: set-points, modes, the stop.
 *
 * The bench follows an excitation; here that is a single straight move, laid anew at each tick
 * through the set-point with its speed. A torque feedforward is the shift of the set-point at which
 * the position control gives just that torque.
 */
#ifndef ORDERS_H
#define ORDERS_H

#include "leg_bus.h"
#include "talus/experimental/excitation.h"
#include "talus/experimental/twin.h"

struct orders {
  const tl_model *model;
  const tl_twin_settings *bench; /* as the drives are when nobody stops them */
  const tl_limits *limits;       /* set-points are kept within these positions */
  int follow;                    /* set-points count; else the twin has its own excitation */
  struct leg_bus_setpoint last[TL_MAX_JOINTS];
  int fresh[TL_MAX_JOINTS];    /* has a new set-point come since the last tick? */
  int begun;                   /* has any come? */
  unsigned long command_age;   /* ticks since the last one */
  unsigned long heartbeat_age; /* ticks since the host's last */
  int has_heartbeat;
  enum leg_bus_mode asked, state; /* by the host's heartbeat; what the bench does */
  unsigned long taken, missed, clamped;
};

/* The excitation that stands still at joint angles 0. */
void orders_rest(tl_excitation *e, int joints);
void orders_init(struct orders *o, const tl_model *m, const tl_twin_settings *bench, const tl_limits *limits,
                 int follow);
/* One frame from the bus. */
void orders_take(struct orders *o, const struct leg_bus_frame *frame);
/* Once a tick, t_s after the recording's beginning: sets reference and drives as ordered. */
void orders_apply(struct orders *o, double t_s, tl_excitation *e, tl_twin *b);

#endif
