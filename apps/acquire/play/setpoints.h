/* setpoints.h: a trajectory as set-points of the leg: what a bench can follow, within what its joints can do. */
#ifndef SETPOINTS_H
#define SETPOINTS_H

#include "common/error.h"
#include "motion/limits.h"
#include "motion/trajectory.h"

enum { SETPOINT_JOINTS = 2 };

/* Reads the file; its rows are sent as they stand, so their steps must be of a length that a bench can follow. */
int setpoints_read(struct trajectory *t, const char *path, struct app_error *error);
/* Limits as --limits gives them: 0, or -1. Both joints need position and speed. */
int setpoints_limits(const char *text, tl_limits limits[SETPOINT_JOINTS], struct app_error *error);
/* The first row that breaks a limit is the error. */
int setpoints_check(const struct trajectory *t, const tl_limits limits[SETPOINT_JOINTS],
                    struct app_error *error);

#endif
