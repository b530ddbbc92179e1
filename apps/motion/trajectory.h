/* trajectory.h: a motion that somebody wrote down, to be followed: time and joint angles (docs/trajectory.md).
 *
 *     struct trajectory t;
 *     if (trajectory_read(path, &model, &t, &error) != 0) return app_exit(&error);
 *     trajectory_at(&t, t_s, &motion);   // q, v, a at an instant, 0 being the first row's
 *     trajectory_free(&t);
 *
 * Between the rows runs a cubic spline that begins and ends at rest, so that speed and acceleration have no jumps.
 * Before the first row and behind the last the joints stand still.
 */
#ifndef TRAJECTORY_H
#define TRAJECTORY_H

#include <stddef.h>

#include "common/error.h"
#include "talus/plant.h"

#define TRAJECTORY_MIN_ROWS 10

struct trajectory {
  const char *path; /* as given */
  int joints;
  size_t rows;
  double *t_s;                 /* from 0 on */
  double *q[TL_MAX_JOINTS];    /* [rad] or [m] */
  double *bend[TL_MAX_JOINTS]; /* the spline's acceleration at the rows */
};

/* Reads a file for a plant's joints: 0, or -1 with status 2 when the file is at fault, naming line or column.
 * Columns that are not known are left aside with a note. On failure there is nothing to free. */
int trajectory_read(const char *path, const tl_model *model, struct trajectory *out, struct app_error *error);
void trajectory_free(struct trajectory *t);

/* Position, velocity and acceleration; slip becomes 0. */
void trajectory_at(const struct trajectory *t, double t_s, tl_motion *motion);
/* From the first row to the last [s]. */
double trajectory_length_s(const struct trajectory *t);

#endif
