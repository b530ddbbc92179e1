/* merge.h: the camera's angles at a recording's samples. */
#ifndef TRACK_MERGE_H
#define TRACK_MERGE_H

#include "recording/recording.h"
#include "track/align/align.h"

struct merge_result {
  size_t rows, outside,
      unseen; /* written; left out before or after the film; valid = 0 for want of pictures */
  double interpolation_rad[2]; /* what interpolating adds, estimated from the pictures themselves */
};

/* Copies the recording's rows that lie within the film, with shank_rad and foot_rad of these series (the camera's times).
 * A row that has no pictures close by (a marker was hidden) has valid = 0. */
int merge_write(const char *path, struct recording *recording, const struct series angle[2],
                const struct clock_fit *clock, struct merge_result *result, struct app_error *error);
/* What a cubic through the neighbours misses: from pictures left out, less their noise. */
double merge_interpolation(const struct series *s, double sigma_rad);

#endif
