/* align.h: the camera's clock against the recording's.
 *
 * tau = middle_rec_s + (1 + rate) (t - middle_cam_s) is the recording's time of the camera's time t. All fits start from
 * and answer such a clock; its uncertainty is that of the offset at the film's middle, and of the rate.
 */
#ifndef TRACK_ALIGN_H
#define TRACK_ALIGN_H

#include <stddef.h>

#include "common/error.h"

/* Samples at rising times. */
struct series {
  size_t n;
  const double *t_s, *x;
};

struct clock_fit {
  double middle_cam_s, middle_rec_s, rate; /* rate: 1e-6 is one part in a million */
  double offset_sigma_s, rate_sigma;
  double correlation;          /* of the joint's velocity, at the best lag */
  double gain[2], constant[2]; /* camera = constant + gain * encoder: shank, and foot less shank */
  double residual_rad[2];
  size_t samples[2];
};

static inline double clock_to_rec(const struct clock_fit *c, double cam_s) {
  return c->middle_rec_s + (1.0 + c->rate) * (cam_s - c->middle_cam_s);
}

static inline double clock_to_cam(const struct clock_fit *c, double rec_s) {
  return c->middle_cam_s + (rec_s - c->middle_rec_s) / (1.0 + c->rate);
}

/* The cubic through the two samples on either side (shifted inwards at the ends): value and slope; *widest is the largest
 * step among the four. -1 outside the series or with fewer than four samples. Nullable: slope, widest. */
int series_cubic(const struct series *s, double t_s, double *value, double *slope, double *widest);

/* What the camera and the encoders show of the same joints: the shank, and foot less shank (n may be 0). */
struct align_data {
  struct series camera[2], encoder[2];
};

/* The lag at which the shank's velocities correlate best, as a clock of rate 0; within a second of an offset (recording less
 * camera) where one is given. -1 with status 2 where they have no motion in common, or one that repeats itself.
 * Nullable: near_s. */
int align_coarse(const struct align_data *data, const double *near_s, struct clock_fit *clock,
                 struct app_error *error);
/* Offset and rate to a fraction of a sample, by least squares (which is the maximum of the correlation), with the uncertainty that
 * the residual's own correlation leaves. -1 with status 1 or 2. */
int align_fine(const struct align_data *data, struct clock_fit *clock, struct app_error *error);

/* Lamp: brightness of each picture; edges: the recording's times, and whether the lamp is on from there. */
struct flash_data {
  struct series lamp, edge;
  double exposure_s; /* 0: unknown */
};
/* Replaces the clock and its uncertainty by what the flashes say. */
int align_flashes(const struct flash_data *data, struct clock_fit *clock, struct app_error *error);

#endif
