/* setpoints.h: the set-points of an excitation, from a file, and what the joints can do.
 *
 * CSV with a header: time_s, knee_rad, ankle_rad; optional knee_velocity_rad_s, knee_torque_Nm (and ankle_):
 * without them the velocity is that of the positions, the torque 0. Lines that begin with # are comments.
 */
#ifndef SETPOINTS_H
#define SETPOINTS_H

#include "common/error.h"
#include "talus/experimental/excitation.h"

enum { SETPOINT_JOINTS = 2 };

struct setpoint {
  double t_s;
  struct {
    double q_rad, v_rad_s, torque_Nm;
  } joint[SETPOINT_JOINTS];
};

struct setpoints {
  const char *path;
  struct setpoint *row;
  size_t rows;
};

/* Reads and checks what any trajectory must be: numbers, time that rises in steps that a bench can follow. */
int setpoints_read(struct setpoints *t, const char *path, struct app_error *error);
void setpoints_free(struct setpoints *t);

/* "knee.position=-0.9:0.1,knee.speed=4,...": 0, or -1. Both joints need position and speed. */
int setpoints_limits(const char *text, tl_limits limits[SETPOINT_JOINTS], struct app_error *error);
/* The first row that breaks a limit is the error. */
int setpoints_check(const struct setpoints *t, const tl_limits limits[SETPOINT_JOINTS],
                    struct app_error *error);

#endif
