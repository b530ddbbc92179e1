/* excitation.h: reference trajectories that move a joint so that it can be identified.
 *
 * Three kinds: the periodic Fourier series (14) of the source paper, a multisine
 * with random phases, and slow ramps with holds. Each is checked against the
 * limits of the joints before it runs, and can be scaled to fit them.
 *
 *     tl_limits limits[TL_MAX_JOINTS] = {tl_limits_none(), tl_limits_none()};
 *     limits[0].speed = 5.0;
 *     tl_excitation e;
 *     tl_peak peak[TL_MAX_PEAKS];
 *     int broken;
 *     if (tl_excitation_paper(&e, 2) != TL_OK ||
 *         tl_excitation_check(&model, limits, &e, peak, &broken) != TL_OK || // what it breaks, by how much, when
 *         tl_excitation_fit(&model, limits, &e, NULL) != TL_OK) return 1;    // smaller, then slower
 *     tl_motion motion;
 *     tl_excitation_at(&e, 1.5, &motion); // q, v, a at an instant
 *     printf("%s\n", tl_quantity_name(peak[0].quantity)); // prints speed
 *
 * Joint coordinates and units are those of plant.h: [rad], or [m] for a slider.
 */
#ifndef TALUS_EXCITATION_H
#define TALUS_EXCITATION_H

#include <stdint.h>

#include "talus/plant.h"
#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_MAX_HARMONICS 32
#define TL_MAX_MOVES 64
#define TL_RAMP_SPEEDS 3

typedef enum tl_excitation_kind {
  TL_EXCITATION_FOURIER = 0, /* (14): offset + sum of sines and cosines, for ever */
  TL_EXCITATION_RAMPS = 1    /* straight moves and holds, then rest at the last one's end */
} tl_excitation_kind;

/* One straight move of all joints together: constant acceleration for ramp_s,
 * constant speed, constant deceleration for ramp_s. A hold where from = to. */
typedef struct tl_move {
  double begin_s, duration_s; /* duration >= 2 ramp_s */
  double ramp_s;              /* >= 0 */
  double from[TL_MAX_JOINTS]; /* about the offset */
  double to[TL_MAX_JOINTS];
} tl_move;

/* Plain data: q_j(t) = offset_j + fade(t) x_j(t), where x_j is the series
 *   sum over i = 1..harmonics of sine_j,i sin(i w t) + cosine_j,i cos(i w t), w = 2 pi base_hz,
 * or the moves. `fade` rises from 0 at t = 0 to 1 at fade_s with continuous acceleration. */
typedef struct tl_excitation {
  tl_excitation_kind kind;
  int joints;                   /* 1..TL_MAX_JOINTS */
  double fade_s;                /* >= 0; 0: at full amplitude from the start */
  double offset[TL_MAX_JOINTS]; /* [rad] or [m] */
  double base_hz;               /* > 0 */
  int harmonics;                /* 0..TL_MAX_HARMONICS */
  double sine[TL_MAX_JOINTS][TL_MAX_HARMONICS];
  double cosine[TL_MAX_JOINTS][TL_MAX_HARMONICS];
  int moves; /* 0..TL_MAX_MOVES */
  tl_move move[TL_MAX_MOVES];
} tl_excitation;

/* (14) as printed: base frequency 2.5 Hz, five harmonics, sines of 0.2 and
 * cosines of 0.1 at the first joint, half of that at the second; no fade. */
TL_CHECK tl_status tl_excitation_paper(tl_excitation *e, int joints);

typedef struct tl_multisine_settings {
  double base_hz;               /* > 0 */
  int harmonics;                /* 1..TL_MAX_HARMONICS */
  double exponent;              /* amplitudes fall as harmonic^-exponent; 1: flat in velocity, 0: in angle */
  double centre[TL_MAX_JOINTS]; /* middle of the range [rad] or [m] */
  double amplitude[TL_MAX_JOINTS]; /* half of the range, >= 0 [rad] or [m] */
  double fade_s;                   /* >= 0 */
  uint64_t seed;                   /* of the phases */
} tl_multisine_settings;

/* For the plant: a period of 4 s, eight harmonics (0.25 to 2 Hz), exponent 0.5, fade 2 s, seed 1. */
tl_multisine_settings tl_multisine_defaults(const tl_model *m);
/* Random phases, uniform: another seed is another realisation. The offset is chosen so that the
 * motion fills centre +- amplitude. TL_ERR_RANGE for settings out of range. */
TL_CHECK tl_status tl_excitation_multisine(tl_excitation *e, int joints, const tl_multisine_settings *s);

typedef struct tl_ramp_settings {
  double speed[TL_RAMP_SPEEDS];    /* of the faster joint, > 0 [rad/s] or [m/s] */
  double amplitude[TL_MAX_JOINTS]; /* largest excursion from the offset [rad] or [m] */
  double travel_s;                 /* a slow ramp covers no more than this time allows from the offset */
  double hold_s;                   /* rest at each end, >= 0 */
  double acceleration;             /* at each end of a ramp, > 0 [rad/s^2] or [m/s^2] */
} tl_ramp_settings;

/* For the plant: speeds of 0.3, 0.09 and 0.03 rad/s, about 50 s for the leg. */
tl_ramp_settings tl_ramp_defaults(const tl_model *m);
/* Back and forth at each speed: the first joint alone, the second alone, then both. */
TL_CHECK tl_status tl_excitation_ramps(tl_excitation *e, int joints, const tl_ramp_settings *s);

/* Position, velocity and acceleration at t_s, in closed form; slip becomes 0. Before t = 0
 * and behind the last move it rests. */
void tl_excitation_at(const tl_excitation *e, double t_s, tl_motion *motion);
/* The period of a series, the whole length of ramps [s]. */
double tl_excitation_length_s(const tl_excitation *e);
/* `factor` times as fast: speeds grow with it, accelerations with its square. factor > 0. */
void tl_excitation_speed_up(tl_excitation *e, double factor);

/* ---- limits -------------------------------------------------------------- */

/* What a joint can do; infinity where there is no limit. `torque` is that of tl_inverse:
 * the leg's motor torque, the pendulum's joint torque, the slider's force. */
typedef struct tl_limits {
  double position_low, position_high; /* [rad] or [m] */
  double speed;                       /* > 0 [rad/s] or [m/s] */
  double acceleration;                /* > 0 [rad/s^2] or [m/s^2] */
  double torque;                      /* > 0 [N m] or [N] */
} tl_limits;

/* No limit at all. */
tl_limits tl_limits_none(void);

typedef enum tl_quantity {
  TL_QUANTITY_POSITION_LOW = 0,
  TL_QUANTITY_POSITION_HIGH = 1,
  TL_QUANTITY_SPEED = 2,
  TL_QUANTITY_ACCELERATION = 3,
  TL_QUANTITY_TORQUE = 4
} tl_quantity;
#define TL_QUANTITIES 5
#define TL_MAX_PEAKS (TL_MAX_JOINTS * TL_QUANTITIES)

/* "position" (twice), "speed", "acceleration", "torque"; NULL when out of range. */
const char *tl_quantity_name(tl_quantity quantity);

/* The largest value of one quantity at one joint (the smallest for POSITION_LOW). */
typedef struct tl_peak {
  int joint;
  tl_quantity quantity;
  double peak;   /* with its sign */
  double limit;  /* with the sign of the side that the peak is on */
  double excess; /* how far beyond the limit, > 0 when it is broken; -infinity without a limit */
  double t_s;    /* when */
} tl_peak;

/* All peaks over the fade and one period (or all moves): joint after joint, in the order of
 * tl_quantity. Found on a grid of at least 64 points a period of the highest harmonic and
 * refined between its points. Friction acts against the motion (tl_slip_from_velocity). */
void tl_excitation_peaks(const tl_model *m, const tl_limits limits[TL_MAX_JOINTS], const tl_excitation *e,
                         tl_peak peak[TL_MAX_PEAKS]);
/* Every limit that is broken, in the same order; their number in *broken. TL_ERR_ARGUMENT when
 * the joints are not the plant's. */
TL_CHECK tl_status tl_excitation_check(const tl_model *m, const tl_limits limits[TL_MAX_JOINTS],
                                       const tl_excitation *e, tl_peak peak[TL_MAX_PEAKS], int *broken);

typedef struct tl_scaling {
  double amplitude[TL_MAX_JOINTS]; /* factor on each joint's excursion from its offset, <= 1 */
  double speed;                    /* factor on the base frequency, <= 1 */
} tl_scaling;

/* Make it fit: first each joint's amplitude is reduced into its position limits (about its
 * offset), then all is slowed down (fade and ramps with it) until speed, acceleration and
 * torque hold; the torque's factor by bisection. The result stays 1e-6 inside the limits.
 * TL_ERR_RANGE when an offset lies outside its position limits, TL_ERR_NO_CONVERGENCE when
 * the torque limit is broken even a thousand times slower (gravity and friction alone break
 * it). Nullable: scaling. */
TL_CHECK tl_status tl_excitation_fit(const tl_model *m, const tl_limits limits[TL_MAX_JOINTS],
                                     tl_excitation *e, tl_scaling *scaling);

#ifdef __cplusplus
}
#endif
#endif
