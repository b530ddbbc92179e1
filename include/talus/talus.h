/* talus.h: what a controller or a program links, and the ways to use it.
 *
 *     #include <talus/talus.h>
 *     tl_model arm;
 *     if (tl_model_init(&arm, TL_PLANT_PENDULUM) != TL_OK) return 1;
 *     puts(tl_joint_name(&arm, 0)); // prints joint
 *
 * talus identifies the dynamics of a powered joint or leg from the currents of
 * its motors, and computes torques from what it identified. Each header can be
 * used alone and begins with a worked call; this one includes all that keep
 * their promises from version to version. What may still change stands in
 * experimental.h: effects, simulation, trajectories, rows for a fit.
 *
 * Torques from a model: fill a tl_model (plant.h), then tl_inverse gives the
 * motor torques of a motion and tl_forward the motion that torques make. Both
 * take a bounded time and little stack, and fit a control loop; transmission.h
 * holds the drives, among them a screw linkage and its table.
 *
 * Motion from a recording: tl_reconstruct (signal.h) fits sliding polynomials to
 * an encoder's angles at their true times and answers position, velocity and
 * acceleration; kinematics.h does so for all joints of a plant. score.h compares
 * measured with predicted in the one way that every program reports.
 *
 * A model from recordings: tl_regressor (plant.h) writes an instant's torque as
 * a linear function of the base parameters, tl_factor_add (factor.h) folds any
 * number of such rows into one small triangle, and identify.h searches the
 * physical parameters by the swarm of pso.h, at a cost independent of the rows.
 *
 * Recordings without a bench (experimental.h): excitation.h makes reference trajectories and
 * checks them against a joint's limits, simulate.h moves the plant under control.
 *
 * Rules that hold everywhere. The caller owns all memory: a function that needs
 * scratch says how much (..._workspace, ..._memory), nothing is allocated and
 * nothing is kept between calls, so different objects may be used by different
 * threads. What can fail answers a tl_status and leaves its outputs alone.
 * Nothing prints, exits or reads a clock. Units are SI and stand in the names.
 * Results are the same bits on every machine with IEEE 754 doubles (math.h,
 * random.h); they may differ between versions of the library (version.h).
 */
#ifndef TALUS_TALUS_H
#define TALUS_TALUS_H

/* what every call shares */
#include "talus/status.h"
#include "talus/version.h"

/* numbers */
#include "talus/factor.h"
#include "talus/math.h"
#include "talus/pso.h"
#include "talus/random.h"

/* mechanics */
#include "talus/plant.h"
#include "talus/transmission.h"

/* control */
#include "talus/controller.h"
#include "talus/curve.h"
#include "talus/drive_table.h"
#include "talus/fixed.h"

/* recordings */
#include "talus/channel.h"
#include "talus/filter.h"
#include "talus/kinematics.h"
#include "talus/score.h"
#include "talus/signal.h"

/* pictures */
#include "talus/marker.h"

/* identification */
#include "talus/identify.h"

#endif
