/* feed.h: the controller between a bus and a motion to follow: state frames in, set-points with feedforward torque out,
 * a call a tick. It opens no socket and knows no clock, so that the simulated bench and a real one drive the same code.
 *
 *     feed_init(&feed, &file, &controller, &trajectory, speed_lag_s);
 *     for (;;) {                                             // every tick
 *       while (... a frame ...) feed_take(&feed, &frame);    // what the drives measured
 *       feed_tick(&feed, t_s, 1, &setpoint, torque_Nm);      // position, Velocity, TorqueFeedforward of the commands
 *     }
 */
#ifndef FEED_H
#define FEED_H

#include "controller/controller_options.h"
#include "leg_bus/leg_bus.h"
#include "motion/trajectory.h"
#include "talus/controller.h"

#define FEED_STATUS_BITS 12 /* all but TL_CONTROLLER_SATURATED, which a double never is */

/* a bench's drives: 100 Hz first order on the change of the motor's angle within a tick, as the twin's */
#define FEED_SPEED_LAG_S 0.00164

struct feed {
  const struct model_file *file;
  const struct controller *controller;
  const struct trajectory *motion;
  double speed_lag_s;
  tl_controller_state_f64 state;
  tl_controller_input_f64 in;
  tl_controller_output_f64 out; /* of the last tick */
  struct leg_bus_encoder encoder[TL_CONTROLLER_JOINTS];
  uint16_t counter[TL_CONTROLLER_JOINTS]; /* of the last state frames */
  int came[TL_CONTROLLER_JOINTS];         /* a state frame has come */
  uint16_t last_counter;                  /* of the last measured frame that was whole */
  int stopped;                            /* a stop frame has come, whoever sent it: no torque any more */
  double peak_Nm[TL_CONTROLLER_JOINTS];
  unsigned long ticks, frames, told[FEED_STATUS_BITS]; /* ticks with each bit of the status */
};

/* The file must have a `bus:`; what is given must outlive it. A drive's own speed is late by its filter; the speed that it
 * is told is as late, or the difference would be torque. Nullable: file and controller, together: no feedforward. */
void feed_init(struct feed *f, const struct model_file *file, const struct controller *controller,
               const struct trajectory *motion, double speed_lag_s);
/* One frame from the bus; others than states and the stop are left aside. */
void feed_take(struct feed *f, const struct leg_bus_frame *frame);
/* What the drives are told at t_s of the motion: angle and speed, and motor torque [Nm] for the tick that follows, whatever
 * has come or not. enable = 0: torque down to zero. */
void feed_tick(struct feed *f, double t_s, int enable, tl_motion *setpoint,
               double torque_Nm[TL_CONTROLLER_JOINTS]);
/* What a bit of the status is called, "stale measured". */
const char *feed_status_name(int bit);

#endif
