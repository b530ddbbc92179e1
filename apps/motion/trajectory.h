/* trajectory.h: a motion that somebody wrote down, to be followed: time, joint angles, and what a drive is told
 * besides (docs/trajectory.md).
 *
 *     struct trajectory t;
 *     if (trajectory_read(path, &model, NULL, &t, &error) != 0) return app_exit(&error);
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

#define TRAJECTORY_MIN_ROWS 2
#define TRAJECTORY_QUANTITIES 3 /* position, speed, torque */
#define TRAJECTORY_COLUMNS (1 + TRAJECTORY_QUANTITIES * TL_MAX_JOINTS)

struct trajectory {
  const char *path; /* as given */
  int joints;
  size_t rows;
  double begin_s; /* the first row's time in the file */
  double *
      column[TRAJECTORY_COLUMNS]; /* time, then positions, speeds and torques; NULL where the file has none */
  double *t_s;                    /* from 0 on */
  double *q[TL_MAX_JOINTS];       /* [rad] or [m] */
  double *bend[TL_MAX_JOINTS];    /* the spline's acceleration at the rows */
};

/* The time from row to row that whoever plays the rows can keep to. */
struct trajectory_steps {
  double shortest_s, longest_s;
};

/* Reads a file for a plant's joints (of the model only the plant counts): 0, or -1 with status 2 when the file is at
 * fault, naming line or column. Columns that are not known are left aside with a note. On failure there is nothing
 * to free. Nullable: steps (any that rise). */
int trajectory_read(const char *path, const tl_model *model, const struct trajectory_steps *steps,
                    struct trajectory *out, struct app_error *error);
void trajectory_free(struct trajectory *t);
/* The same motion in rows of an even step, with a rest before and behind it; speeds and torques of the file are dropped.
 * 0, or -1 with status 1: out of memory; it is as it was then. */
int trajectory_resample(struct trajectory *t, double step_s, double rest_s, struct app_error *error);

/* Position, velocity and acceleration; slip becomes 0. */
void trajectory_at(const struct trajectory *t, double t_s, tl_motion *motion);
/* From the first row to the last [s]. */
double trajectory_length_s(const struct trajectory *t);

/* What a drive is told at a row: the file's speed, or else the spline's; the file's torque, or else 0. */
double trajectory_speed(const struct trajectory *t, size_t row, int joint);
double trajectory_torque(const struct trajectory *t, size_t row, int joint);
/* Does the file have any speed or torque? */
int trajectory_orders_drives(const struct trajectory *t);

#endif
