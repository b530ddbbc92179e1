/* simulate.h: a plant in forward time, with Coulomb friction that really sticks.
 *
 * Each joint slides in one direction, or sticks. Between changes the equations
 * are smooth and take Runge-Kutta steps of fourth order; the instant at which a
 * sliding joint comes to rest, or at which a sticking one breaks loose, is found
 * on the step's own length, so that no step straddles a change and the order is
 * kept. There is no regularisation: a joint that sticks stands still to the last bit.
 *
 *     const double q[TL_MAX_JOINTS] = {0.0}, v[TL_MAX_JOINTS] = {0.0}; // at rest
 *     double torque_Nm[TL_MAX_JOINTS] = {0.1, 0.0};                    // too little to break loose
 *     tl_simulation s;
 *     if (tl_simulation_init(&s, &model, q, v) != TL_OK ||
 *         tl_simulate(&model, tl_held_torque, torque_Nm, 0.001, &s, s.t_s + 0.01) != TL_OK) return 1;
 *     printf("%g rad, slip %g\n", s.motion.q[0], s.motion.slip[0]); // prints 0 rad, slip 0.5
 *
 * s.motion.slip is the friction's share of the level at which a joint gives way.
 *
 * Effects (talus/experimental/effect.h) act when s.effect and s.effects name them: the mechanical ones on the
 * joints, their friction beside Coulomb's, so that a joint sticks on both. Steps are then shortened
 * where an effect bends or is stiff.
 */
#ifndef TALUS_SIMULATE_H
#define TALUS_SIMULATE_H

#include "talus/experimental/effect.h"
#include "talus/plant.h"
#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_EVENT_TIME_S 1e-12 /* instants of change are located to this */

typedef enum tl_joint_mode {
  TL_MODE_BACKWARD = -1, /* slides with v <= 0 */
  TL_MODE_STICK = 0,     /* v = 0, friction between the levels of the two directions */
  TL_MODE_FORWARD = 1,   /* slides with v >= 0 */
  TL_MODE_FREE = 2       /* no Coulomb friction: nothing to stick */
} tl_joint_mode;

#define TL_LINK_BODIES (TL_MAX_JOINTS + TL_MOUNT_MODES)
/* Where dry friction acts, and a mode says how: at the joint j (on its motor's side), at its link, where part of it
 * stands there: TL_CONTACT_LINK + j, or between motor and link: TL_CONTACT_DRAG + j. */
enum { TL_CONTACT_LINK = TL_MAX_JOINTS, TL_CONTACT_DRAG = 2 * TL_MAX_JOINTS };
#define TL_CONTACTS (3 * TL_MAX_JOINTS)

/* What effects add to the plant's state. Where a transmission is not rigid, tl_simulation's motion is the
 * motor's side in the joint's coordinate, where friction is, and the joint stands apart from it. */
typedef struct tl_link_state {
  int begun;
  /* joints beyond their transmissions, then the mount's modes in the order of tl_effect_change */
  double q[TL_LINK_BODIES], v[TL_LINK_BODIES], a[TL_LINK_BODIES];
  double slip[TL_MAX_JOINTS]; /* of a link's own friction, as tl_motion's */
  double drag_slip[TL_MAX_JOINTS],
      drag_a[TL_MAX_JOINTS];                      /* of the drag, and what its motor gains on the link */
  double z[TL_MAX_JOINTS], z_rate[TL_MAX_JOINTS]; /* presliding's memory, [-1, 1] */
} tl_link_state;

/* Where the plant stands. Plain data: a copy can be continued as well. */
typedef struct tl_simulation {
  double t_s;
  tl_motion motion; /* q, v; a and slip as they are at t_s, before any later change of torque */
  tl_joint_mode mode[TL_CONTACTS];
  double work_J; /* what motors (less the model's torque or force offset) have put in */
  double
      dissipated_J; /* what friction has taken, and effects: kinetic + potential + dissipated - work stays */
  unsigned long changes; /* of mode so far: stops, reversals and breakaways */
  /* what acts beside the model, set by the caller after tl_simulation_init; it must outlive the
   * simulation. Those that act on measurements alone are left aside. Nullable: effect when effects is 0. */
  const tl_effect *effect;
  int effects;
  double effects_begin_s; /* the instant from which effects of time count */
  tl_link_state link;     /* all 0 without effects of this sort */
} tl_simulation;

/* Torque at an instant, as tl_forward takes it. Smooth within one call of tl_simulate; what it
 * depends on is in `context`. */
typedef void (*tl_torque_law)(const void *context, double t_s, const tl_motion *motion,
                              double torque[TL_MAX_JOINTS]);

/* The law of a constant torque: context is const double[TL_MAX_JOINTS]. */
void tl_held_torque(const void *context, double t_s, const tl_motion *motion, double torque[TL_MAX_JOINTS]);

/* At t = 0 with joint positions q and velocities v. TL_ERR_UNSUPPORTED for `form: paper` with
 * Coulomb friction: there it acts between bodies that no joint connects, and cannot stick. */
TL_CHECK tl_status tl_simulation_init(tl_simulation *s, const tl_model *m, const double q[TL_MAX_JOINTS],
                                      const double v[TL_MAX_JOINTS]);

/* Where the joints themselves are: s->motion but for transmissions that twist or err in angle. */
void tl_simulation_joints(const tl_model *m, const tl_simulation *s, tl_motion *joints);
/* By how much a mount that turns adds to every absolute angle [rad]. */
double tl_simulation_base_angle(const tl_simulation *s);

/* On to until_s >= s->t_s, in equal steps of at most step_s and shorter ones at changes. A joint that
 * would stop and start again the same way within one step is not seen to do so: step_s should be
 * small against such motion (1 ms serves actuators of this kind). Where several joints are at rest
 * together the one solution of all of them is taken.
 * TL_ERR_NOT_FINITE when the motion leaves the numbers, TL_ERR_SINGULAR as tl_forward,
 * TL_ERR_NO_CONVERGENCE after 100 changes within a nanosecond of each other, or where friction grows
 * with the load so fast that a joint jams. On failure *s is where it was last sound. */
TL_CHECK tl_status tl_simulate(const tl_model *m, tl_torque_law law, const void *context, double step_s,
                               tl_simulation *s, double until_s);

/* A recorded motion on an even grid, and windows of it that are simulated anew from the recorded state under the
 * recorded torque: in open loop a simulation runs away from any recording. */
typedef struct tl_windows {
  const tl_model *model;
  const tl_effect *effect; /* as in tl_simulation. Nullable when effects is 0. */
  int effects;
  double begin_s; /* of row 0: time of the effects */
  double step_s;
  double longest_step_s;                             /* of the integration */
  const double *q[TL_MAX_JOINTS], *v[TL_MAX_JOINTS]; /* recorded, by row */
  const double *torque[TL_MAX_JOINTS];               /* as tl_forward takes it; straight between rows */
  const size_t *first;                               /* row at which each window begins */
  size_t count, steps;                               /* windows, and the rows that each goes on */
  double *deviation; /* simulated less recorded q at row first + k + 1 of window i and joint j:
                      * [(j steps + k) count + i] */
} tl_windows;

/* Fills w->deviation. Errors of tl_simulation_init and tl_simulate. */
TL_CHECK tl_status tl_simulate_windows(const tl_windows *w);

/* What a drive's position loop sees of its encoder: x on a grid of some step, 0: exact. */
double tl_loop_grid(double x, double step);

/* One tick of such a loop: the low-passed speed of what it sees, in the unit of `seen` per second. *position is what it
 * saw a tick before, *speed the speed that it had then; both are left for the next tick. share, 0 to 1: how much of each
 * change a first-order low-pass of f Hz lets through in a tick, 1 - exp(-2 pi f / tick_hz). */
double tl_loop_speed(double seen, double tick_hz, double share, double *position, double *speed);

/* The position loop of a joint's drive, which ticks every longest_step_s: its torque is what it orders, less stiffness
 * times the position that its encoder shows, less damping times the low-passed speed of that. */
typedef struct tl_replay_loop {
  double stiffness, damping; /* torque, as tl_forward takes it, by tl_drive_position and its speed */
  double velocity_hz;        /* of the first-order low-pass on the speed, above 0 */
  double step, offset;       /* of the encoder's grid. A step of 0: exact */
  const double *order;       /* (ticks). NULL: no loop */
} tl_replay_loop;

/* A recorded motion driven once more: the plant under the recorded torque, and a weak loop that keeps it near the
 * recorded motion; or under its drive's own loop, which turns the encoder's steps into torque. What comes out is a motion
 * that obeys the model to the last bit, and is as rough as the recorded one: recorded anew by the same sensors it shows
 * what these and the reconstruction leave where nothing is hidden. */
typedef struct tl_replay {
  const tl_model *model;
  const tl_effect *effect; /* as in tl_simulation. Nullable when effects is 0. */
  int effects;
  double
      loop_hz; /* of the loop, critically damped: torque for position error is (2 pi loop_hz)^2 dtorque/da */
  double longest_step_s;              /* of the integration */
  tl_replay_loop loop[TL_MAX_JOINTS]; /* in the weak loop's and the recorded torque's place */
  double first_tick_s;                /* after row 0: above -longest_step_s, not above 0 */
  size_t ticks;                       /* of each loop's order; after the last its torque is held */
  size_t n;
  const double *t_s; /* (n), rises strictly */
  const double *q[TL_MAX_JOINTS], *v[TL_MAX_JOINTS],
      *torque[TL_MAX_JOINTS]; /* recorded, (n) each; torque as tl_forward takes it */
  /* at the same instants, (n) each: the motor's side in the joint's coordinate, the torque, and the joint beyond its
   * transmission (equal to q_out where that is rigid) */
  double *q_out[TL_MAX_JOINTS], *v_out[TL_MAX_JOINTS], *torque_out[TL_MAX_JOINTS], *joint_out[TL_MAX_JOINTS];
} tl_replay;

/* Fills the outputs; row 0 is the recorded state. Errors of tl_simulation_init and tl_simulate, TL_ERR_NOT_FINITE also
 * where the motion leaves the recorded one by more than 1e6 of its unit. */
TL_CHECK tl_status tl_simulate_replay(const tl_replay *r);

/* Can the mount's modes ring at their frequencies with the leg hanging from them? Not where that takes less than the
 * leg's own inertia. */
int tl_simulation_mount_rings(const tl_model *m, const tl_effect_mount *mount, int modes);

#ifdef __cplusplus
}
#endif
#endif
