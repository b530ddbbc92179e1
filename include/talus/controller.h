/* controller.h: torque feedforward of the leg for a control loop: prepared once, one call a tick.
 *
 *     tl_controller_state_f32 state;
 *     tl_controller_start_f32(&state);
 *     tl_controller_input_f32 in;
 *     while (receive(&in)) { // every millisecond: the desired frame, the measured one, enable
 *       tl_controller_output_f32 out;
 *       tl_controller_tick_f32(&leg, &state, &in, &out);
 *       send(out.current_A[0], out.current_A[1]);
 *     }
 *
 * `leg` is constant: made from a model by tl_controller_prepare (controller_prepare.h), or written as a header by
 * talus-export --to c. The same equations exist in double (_f64), in float (_f32) and in fixed point (_q31), where
 * every number has the Q format that fixed.h gives for its kind and 1 kHz needs no floating-point unit.
 *
 * What a tick does: it takes a desired and a measured frame where they are new and possible, else keeps the last ones
 * and counts their age; computes the torque that the desired motion needs; fades what pushes towards a joint limit that
 * is near; holds torque, rate and power within their limits. After stale_ticks without a good frame, and as long as
 * enable is 0, torque decays to zero within decay_ticks, and comes back as slowly after recover_ticks good ones.
 * Friction is compensated in the direction of the desired speed alone, in proportion to it near standstill: what is
 * measured does not feed it, so it cannot make a limit cycle.
 *
 * Every call takes the same path for all data of a model. Joint 0 is the knee, joint 1 the ankle.
 */
#ifndef TALUS_CONTROLLER_H
#define TALUS_CONTROLLER_H

#include <stdint.h>

#include "talus/curve.h"
#include "talus/fixed.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_CONTROLLER_JOINTS 2
#define TL_POWER_LINES 3              /* straight lines below power / speed */
#define TL_CONTROLLER_MOST_TICKS 1000 /* of stale_ticks, decay_ticks and recover_ticks */

/* What a tick can tell, bits of `status`. 0: the torque is what the model asks for. */
enum {
  TL_CONTROLLER_STALE_DESIRED = 1,  /* no new good frame for more than stale_ticks */
  TL_CONTROLLER_STALE_MEASURED = 2, /* the same of the measured one */
  TL_CONTROLLER_IMPOSSIBLE = 4,     /* a frame was refused: not a number, or beyond what the joint can be */
  TL_CONTROLLER_JUMP = 8,           /* a frame was refused: further from the last than the joint can get */
  TL_CONTROLLER_FROZEN = 16,        /* the measured angle stands still while its speed does not */
  TL_CONTROLLER_STOPPED = 32,       /* enable is 0 */
  TL_CONTROLLER_DECAYING = 64,      /* torque is on its way to zero */
  TL_CONTROLLER_ZERO = 128,         /* torque is zero: after a decay, or before the first recover_ticks */
  TL_CONTROLLER_TORQUE_LIMIT = 256, /* these hold the torque back */
  TL_CONTROLLER_RATE_LIMIT = 512,
  TL_CONTROLLER_POWER_LIMIT = 1024,
  TL_CONTROLLER_JOINT_LIMIT = 2048,
  TL_CONTROLLER_SATURATED = 4096 /* a fixed-point number was held at its range's end */
};

/* What a joint's friction and current are made of beside the plain model, bits of `uses`. */
enum { TL_CONTROLLER_USES_LOAD = 1, TL_CONTROLLER_USES_ASYMMETRY = 2, TL_CONTROLLER_USES_OFFSET = 4 };

/* The types of one scalar; NAME stands for f64, f32 or q31. Bounds that fixed point needs are those of the formats.
 *
 * tl_controller_joint: a joint's numbers. Angles [rad], speeds [rad/s], torques at the joint unless "motor" says so.
 *   ratio, inverse     curves of d motor / d joint and its inverse over the joint angle, in [-1, 1], both with knots at the
 *                      same angles; n = 0: constant
 *   slow, fast         curves of the friction level over |speed| beside dry_Nm, below and above `slow_rad_s`
 *   spring, position   curves of the torque and of the friction level over the joint angle
 *   droop              curve of the motor torque that saturation hides over |motor torque|
 *   ..._scale          what a curve is multiplied with
 *   side               1, or -1 where a positive motor torque moves the joint in the negative direction
 *   power_Nm, power_slope    lines below power / |joint speed|: motor torque at standstill, and its fall per rad/s
 */
#define TL_CONTROLLER_TYPES(REAL, NAME)                                                                      \
  typedef struct tl_controller_joint_##NAME {                                                                \
    tl_curve_##NAME ratio, inverse, slow, fast, spring, position, droop;                                     \
    REAL inverse_scale, slope_per_rad;          /* Q31; Q24: knots per rad */                                \
    REAL friction_gain;                         /* 1 / speed below which friction fades, Q20 */              \
    REAL dry_Nm, speed_scale, asymmetry_Nm;     /* Q21 */                                                    \
    REAL viscous, viscous_asymmetry;            /* N m s/rad, Q23 */                                         \
    REAL load_even, load_odd;                   /* of the load, Q30 */                                       \
    REAL spring_scale, position_scale;          /* Q21 */                                                    \
    REAL slow_rad_s;                            /* Q25 */                                                    \
    REAL torque_limit_Nm, rate_Nm;              /* of the motor, per tick, Q26 */                            \
    REAL power_Nm[TL_POWER_LINES];              /* of the motor, Q26 */                                      \
    REAL power_slope[TL_POWER_LINES];           /* Q23 */                                                    \
    REAL low_rad, high_rad, fade_gain;          /* Q29; 1 / rad, Q22 */                                      \
    REAL middle_rad, reach_rad;                 /* frames are within reach of the middle, Q29 */             \
    REAL speed_limit_rad_s, acceleration_limit; /* Q25, Q19 */                                               \
    REAL angle_step_rad, angle_slack_rad;       /* a frame may differ by step per tick and slack, Q29 */     \
    REAL speed_step_rad_s;                      /* Q25 */                                                    \
    REAL frozen_rad_s;                          /* Q25 */                                                    \
    REAL amperes_per_Nm, offset_Nm;             /* of the motor, Q20, Q26 */                                 \
    REAL droop_scale;                           /* Q26 */                                                    \
    int32_t uses;                               /* TL_CONTROLLER_USES_... */                                 \
    int32_t side;                                                                                            \
  } tl_controller_joint_##NAME;                                                                              \
                                                                                                             \
  typedef struct tl_controller_##NAME {                                                                      \
    tl_controller_joint_##NAME joint[TL_CONTROLLER_JOINTS];                                                  \
    REAL shank_inertia, foot_inertia, coupling, rotor; /* kg m^2, Q27 */                                     \
    REAL gravity_shank, gravity_foot;                  /* of sin, N m, Q21 */                                \
    REAL tilt_shank, tilt_foot;                        /* of cos, N m, Q21 */                                \
    int32_t tilted;                                    /* 1: tilt is not 0 */                                \
    REAL per_level;                                    /* 1 / decay_ticks, Q30 */                            \
    int32_t stale_ticks, decay_ticks, recover_ticks;                                                         \
  } tl_controller_##NAME;                                                                                    \
                                                                                                             \
  /* A desired or measured frame. `count` is the sender's counter: a frame is new when it has risen. */      \
  typedef struct tl_controller_frame_##NAME {                                                                \
    REAL angle_rad[TL_CONTROLLER_JOINTS];    /* Q29 */                                                       \
    REAL speed_rad_s[TL_CONTROLLER_JOINTS];  /* Q25 */                                                       \
    REAL acceleration[TL_CONTROLLER_JOINTS]; /* rad/s^2, Q19; of a measured frame not used: 0 */             \
    uint32_t count;                                                                                          \
  } tl_controller_frame_##NAME;                                                                              \
                                                                                                             \
  typedef struct tl_controller_input_##NAME {                                                                \
    tl_controller_frame_##NAME desired, measured;                                                            \
    int32_t enable; /* 0: decay to zero, as an emergency stop asks for */                                    \
  } tl_controller_input_##NAME;                                                                              \
                                                                                                             \
  /* What the torque is made of, at the joint [N m], Q21, before any limit. */                               \
  typedef struct tl_controller_parts_##NAME {                                                                \
    REAL inertia_Nm[TL_CONTROLLER_JOINTS];                                                                   \
    REAL gravity_Nm[TL_CONTROLLER_JOINTS];                                                                   \
    REAL friction_Nm[TL_CONTROLLER_JOINTS]; /* with the effects that are friction */                         \
    REAL effects_Nm[TL_CONTROLLER_JOINTS];  /* springs and tilt */                                           \
  } tl_controller_parts_##NAME;                                                                              \
                                                                                                             \
  typedef struct tl_controller_output_##NAME {                                                               \
    REAL torque_Nm[TL_CONTROLLER_JOINTS]; /* of the motor, Q26: within all limits */                         \
    REAL current_A[TL_CONTROLLER_JOINTS]; /* Q20 */                                                          \
    tl_controller_parts_##NAME parts;                                                                        \
    uint32_t status; /* TL_CONTROLLER_... */                                                                 \
  } tl_controller_output_##NAME;                                                                             \
                                                                                                             \
  /* What a tick keeps for the next; tl_controller_start sets it. */                                         \
  typedef struct tl_controller_state_##NAME {                                                                \
    tl_controller_frame_##NAME desired, measured; /* the last good ones */                                   \
    REAL torque_Nm[TL_CONTROLLER_JOINTS];         /* of the last tick */                                     \
    int32_t desired_age, measured_age;            /* ticks since they came */                                \
    int32_t still[TL_CONTROLLER_JOINTS]; /* frames since the angle changed, while the speed says so */       \
    int32_t level, good;                 /* of decay_ticks; good frames since the last bad one */            \
    int32_t begun;                       /* bit 0: a desired frame has come, bit 1: a measured one */        \
  } tl_controller_state_##NAME;

TL_CONTROLLER_TYPES(double, f64)
TL_CONTROLLER_TYPES(float, f32)
TL_CONTROLLER_TYPES(int32_t, q31)

/* At rest, with nothing received. */
void tl_controller_start_f64(tl_controller_state_f64 *state);
void tl_controller_start_f32(tl_controller_state_f32 *state);
void tl_controller_start_q31(tl_controller_state_q31 *state);

/* One tick: see above. Nothing can fail: whatever comes in, *out is within the limits, and out->status says why. */
void tl_controller_tick_f64(const tl_controller_f64 *c, tl_controller_state_f64 *state,
                            const tl_controller_input_f64 *in, tl_controller_output_f64 *out);
void tl_controller_tick_f32(const tl_controller_f32 *c, tl_controller_state_f32 *state,
                            const tl_controller_input_f32 *in, tl_controller_output_f32 *out);
void tl_controller_tick_q31(const tl_controller_q31 *c, tl_controller_state_q31 *state,
                            const tl_controller_input_q31 *in, tl_controller_output_q31 *out);

/* The law alone, without state and without limits: motor torque [N m] (Q26) of a desired motion, and its parts.
 * Beyond the joint's limits and for NaN it is not meaningful; fixed point sets *saturated where a number was held. */
void tl_controller_torque_f64(const tl_controller_f64 *c, const tl_controller_frame_f64 *desired,
                              double torque_Nm[TL_CONTROLLER_JOINTS], tl_controller_parts_f64 *parts);
void tl_controller_torque_f32(const tl_controller_f32 *c, const tl_controller_frame_f32 *desired,
                              float torque_Nm[TL_CONTROLLER_JOINTS], tl_controller_parts_f32 *parts);
void tl_controller_torque_q31(const tl_controller_q31 *c, const tl_controller_frame_q31 *desired,
                              int32_t torque_Nm[TL_CONTROLLER_JOINTS], tl_controller_parts_q31 *parts,
                              uint32_t *saturated);

#ifdef __cplusplus
}
#endif
#endif
