/* kinematics.h: from a recording's columns to joint motion.
 *
 * Angles become position, velocity and acceleration by sliding windows that
 * never reach across a stop of their own joint: at a stop friction turns over
 * and the acceleration jumps, and a window across it would smear the jump into friction
 * and inertia. Stops are found from the angles alone. docs/signal.md gives the reasons.
 *
 *     tl_layout layout;
 *     tl_sensing sensing[TL_MAX_JOINTS];
 *     tl_score_settings score = tl_score_defaults();
 *     if (tl_layout_init(&layout, &model, recorded) != TL_OK) return 1;
 *     for (int j = 0; j < tl_joint_count(&model); j++) // once a recording
 *       if (tl_kinematics_window(&model, &layout, j, &score, step_s, &block, work, work_n, &sensing[j]) != TL_OK) return 1;
 *     if (tl_kinematics(&model, &layout, sensing, &block, work, work_n, &track) != TL_OK) return 1; // block by block
 *     printf("%.2f rad/s\n", track.v[0][500]); // prints 0.50 rad/s
 */
#ifndef TALUS_KINEMATICS_H
#define TALUS_KINEMATICS_H

#include <stddef.h>
#include <stdint.h>

#include "talus/channel.h"
#include "talus/plant.h"
#include "talus/score.h"
#include "talus/signal.h"
#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_BRIDGE_S 0.1        /* a stop shorter than this is bridged, a longer one is a hold */
#define TL_NO_ROW ((size_t)-1) /* a stop that begins before or ends after the block */

/* Rows of a recording by channel; NULL where a channel was not recorded. Rows of one
 * block are valid and without gap. */
typedef struct tl_block {
  size_t n;
  const double *t_s;                       /* (n), rises strictly */
  const double *channel[TL_CHANNEL_COUNT]; /* (n) each; Nullable */
} tl_block;

/* Which channel tells what; TL_CHANNEL_COUNT where none does. */
typedef struct tl_layout {
  tl_channel position[TL_MAX_JOINTS];
  tl_channel velocity[TL_MAX_JOINTS]; /* used where no position was recorded */
  tl_channel effort[TL_MAX_JOINTS];   /* current, torque or force */
  double effort_scale[TL_MAX_JOINTS]; /* effort channel to [N m] or [N] */
  tl_channel load;                    /* a torque sensor at the output */
} tl_layout;

/* recorded: set of TL_CHANNEL_BIT. TL_ERR_UNSUPPORTED when a required channel is missing. */
TL_CHECK tl_status tl_layout_init(tl_layout *layout, const tl_model *m, uint32_t recorded);

/* How one joint's angle is read, from its own data. */
typedef struct tl_sensing {
  tl_window window;  /* of the reconstruction: order 5 over 1 / lowpass_hz unless chosen by the user */
  int across;        /* 1: the window reaches across stops (a user's own window, such as the paper's) */
  double noise;      /* standard deviation of the recorded angle (or velocity), in its own units */
  double step;       /* its resolution, in its own units; 0 if none was seen */
  tl_window quick;   /* of the velocity that finds the stops: the shortest that tells standstill from noise */
  double standstill; /* |joint velocity| below which the joint counts as standing */
} tl_sensing;

#define TL_SAMPLE_PLACES 8 /* of a recording that its sensing may be measured at */
#define TL_SAMPLE_ROWS 4096
/* Place k of 0..TL_SAMPLE_PLACES-1, spread over the rows of `count` segments: TL_SAMPLE_ROWS of one segment, or all of a
 * shorter one. count >= 1. */
tl_segment tl_sample_place(const tl_segment *segment, size_t count, int k);

/* Measure a joint's sensing on a sample of its rows (a few thousand serve).
 * TL_ERR_TOO_SHORT with fewer rows than 30. */
size_t tl_kinematics_window_workspace(size_t n);
TL_CHECK tl_status tl_kinematics_window(const tl_model *m, const tl_layout *layout, int joint,
                                        const tl_score_settings *score, double step_s, const tl_block *sample,
                                        double *work, size_t work_n, tl_sensing *out);

/* A stop of one joint: it stands between rows `before` and `after` (both still moving). */
typedef struct tl_stop {
  size_t before, after; /* TL_NO_ROW where the block does not show it */
  double begin_s;       /* instant at which it came to rest */
} tl_stop;

/* A column of a joint's torque through its short stops (at most TL_BRIDGE_S): from what the rows before
 * each tell to what those after it do, with the square of the time passed (docs/signal.md); n rows, as the stops
 * count them. */
void tl_bridge_stops(const tl_stop *stop, size_t stops, const double *t_s, size_t n, double *column);

/* Motion of every joint over a block; arrays of the caller's memory, see tl_track_init. */
typedef struct tl_track {
  size_t capacity;
  double *q[TL_MAX_JOINTS], *v[TL_MAX_JOINTS], *a[TL_MAX_JOINTS]; /* [rad] or [m] */
  double *slip[TL_MAX_JOINTS];                                    /* direction of friction, [-1, 1] */
  double *speed[TL_MAX_JOINTS]; /* |velocity| that the score's standstill is judged by */
  tl_stop *stop[TL_MAX_JOINTS]; /* in order of time */
  size_t stops[TL_MAX_JOINTS];
} tl_track;

/* Doubles and stops of memory for blocks of at most `capacity` rows. */
size_t tl_track_memory(int joints, size_t capacity);
void tl_track_init(tl_track *track, int joints, size_t capacity, double *memory, tl_stop *stops);

/* Doubles of workspace for tl_kinematics on blocks of at most `capacity` rows. */
size_t tl_kinematics_workspace(size_t capacity);
/* Joint motion of a block (sensing: one a joint). Within a window of the block's
 * ends the result depends on where the block was cut, elsewhere it does not. */
TL_CHECK tl_status tl_kinematics(const tl_model *m, const tl_layout *layout, const tl_sensing *sensing,
                                 const tl_block *block, double *work, size_t work_n, tl_track *track);

/* Which ends of a slip phase, the motion between two stops, stand beside a stop. */
enum { TL_FROM_REST = 1, TL_TO_REST = 2 };

/* The ends of the slip phase between two stops (NULL: the recording's begin or end) whose rows have windows of their own:
 * those beside a stop that is bridged. */
int tl_slip_phase_edges(const tl_stop *before, const tl_stop *after, const double *t_s);

/* Motion of n rows between two stops by their own windows, of a lower order where they are few. The windows of the
 * first and last row stand to one side: at the `edges` they have one order less (from rest) or two (to rest) over
 * two thirds of the length, which overshoots less there.
 * Nullable: q. TL_ERR_TOO_SHORT with fewer than 4 rows. */
TL_CHECK tl_status tl_reconstruct_slip_phase(const tl_window *window, const double *t_s, const double *x,
                                             size_t n, int edges, double *q, double *v, double *a,
                                             double *work, size_t work_n);

#ifdef __cplusplus
}
#endif
#endif
