/* lockstep.h: the closed loop without a bus and without a clock: the bench twin advances with each tick, on the frames
 * that a bus would carry. What it gives depends on its inputs alone.
 */
#ifndef LOCKSTEP_H
#define LOCKSTEP_H

#include "feed.h"

#define LOCKSTEP_LEAD_S 1.0 /* at rest on the first row, before and after the motion */

/* A tick of the motion, of one joint: what was wanted, and what came of it. */
struct lockstep_joint_instant {
  double desired_rad, measured_rad;                       /* measured: 0 without feedforward */
  double error_rad;                                       /* trajectory less true joint angle */
  double feedforward_Nm, feedback_Nm;                     /* of the motor */
  double inertia_Nm, gravity_Nm, friction_Nm, effects_Nm; /* at the joint, what the model asks for */
};
struct lockstep_instant {
  double t_s; /* of the motion */
  struct lockstep_joint_instant joint[TL_CONTROLLER_JOINTS];
};

struct lockstep {
  const struct model_file *truth; /* with a `bus:` */
  const struct trajectory *motion;
  double speed_lag_s;                                            /* feed.h */
  uint64_t seed;                                                 /* of the sensors' noise */
  void (*see)(void *context, const struct lockstep_instant *at); /* Nullable */
  void *context;
};

/* A joint over the motion, RMS of all ticks. */
struct lockstep_joint {
  double error_rad;      /* trajectory less true joint angle */
  double feedback_Nm;    /* of the motor, by the drive's position control */
  double feedforward_Nm; /* ... by the set-points */
  double total_Nm;
  double share; /* feedback over total */
  double peak_A, limit_A;
  double feedforward_peak_A, feedforward_limit_A; /* what the controller asked for; 0, 0 without one */
  unsigned long limited;                          /* ticks at the drive's limit */
};

struct lockstep_result {
  struct lockstep_joint joint[TL_CONTROLLER_JOINTS];
  unsigned long ticks, told[FEED_STATUS_BITS];
};

/* One run. 0, or -1. Nullable: file and controller, together (no feedforward). */
int lockstep_run(const struct lockstep *l, const struct model_file *file, const struct controller *controller,
                 struct lockstep_result *result, struct app_error *error);

#endif
