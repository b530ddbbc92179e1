/* gap.h: what diagnosis sees of recordings: channels, the operator, and the stack of scored rows.
 *
 * A diagnosis holds its recordings in memory. Each shows one torque channel a joint, and angle
 * channels where a second sensor sees the same angle (joint encoder, camera). Whatever an
 * effect adds to a channel passes the same operator as the plain model's columns: bridged
 * through short stops, put on the even grid, filtered, and masked. docs/diagnosis.md has the method.
 */
#ifndef TALUS_GAP_H
#define TALUS_GAP_H

#include <stddef.h>
#include <stdint.h>

#include "talus/arena.h"
#include "talus/plant.h"
#include "talus/regression.h"
#include "talus/score.h"
#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Channels: torque of joint j is channel j. */
enum {
  TL_GAP_ENCODER = 2, /* ankle_joint_rad less the motor's angle through the linkage [rad] */
  TL_GAP_SHANK = 3,   /* camera's shank angle less the knee motor's over its ratio [rad] */
  TL_GAP_FOOT = 4,    /* camera's angle of the ankle less the motor's through the linkage [rad] */
  TL_GAP_CHANNELS = 5
};

/* One recording, prepared. Arrays of n stand at its rows, arrays of m on the grid of its segments, one
 * after the other. Rows outside segments hold zeros. */
typedef struct tl_gap_recording {
  tl_regression regression;
  size_t n, m;
  const double *t_s;                       /* (n) */
  const double *channel[TL_CHANNEL_COUNT]; /* (n) each; Nullable */
  size_t segments;
  tl_segment *segment; /* rows of each */
  size_t *grid_begin;  /* (segments + 1) first grid instant of each */
  double *grid_s;      /* (m) */
  double *q[TL_MAX_JOINTS], *v[TL_MAX_JOINTS], *a[TL_MAX_JOINTS], *slip[TL_MAX_JOINTS];
  tl_stop *stop[TL_MAX_JOINTS]; /* those that are bridged, rows counted in the recording */
  size_t stops[TL_MAX_JOINTS];
  uint8_t *kind[TL_MAX_JOINTS]; /* (m) TL_ROW_... */
  int columns[TL_MAX_JOINTS], index[TL_MAX_JOINTS][TL_MAX_ROW];
  double *x[TL_MAX_JOINTS];      /* (columns * m) the plain model's, column-major */
  double *target[TL_MAX_JOINTS]; /* (m) measured less known */
  double *measured[TL_MAX_JOINTS];
} tl_gap_recording;

/* Prepare a recording of n rows from its columns (which must outlive it). sensing: one a joint.
 * valid: Nullable. Everything is taken from the arena; TL_ERR_WORKSPACE when that is used up
 * (arena->wanted then tells more than was there), TL_ERR_TOO_SHORT without a usable segment. */
TL_CHECK tl_status tl_gap_prepare(tl_gap_recording *r, const tl_regression *regression,
                                  const tl_block *columns, const uint8_t *valid, tl_arena *arena);

/* The operator's parts: a column at the rows bridged over one joint's stops, in place; rows to grid;
 * and the low-pass, segment by segment, in place. */
void tl_gap_bridge(const tl_gap_recording *r, int joint, double *at_rows);
void tl_gap_resample(const tl_gap_recording *r, const double *at_rows, double *on_grid);
void tl_gap_lowpass(const tl_gap_recording *r, double *on_grid);

#ifdef __cplusplus
}
#endif
#endif
