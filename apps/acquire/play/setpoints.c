/* setpoints.c: see setpoints.h. */
#include "setpoints.h"

#include <math.h>

static const tl_model leg = {.plant = TL_PLANT_LEG};
/* from row to row: the bus's load; what a bench bridges */
static const struct trajectory_steps steps = {.shortest_s = 0.0002, .longest_s = 0.05};

int setpoints_read(struct trajectory *t, const char *path, struct app_error *error) {
  return trajectory_read(path, &leg, &steps, t, error);
}

int setpoints_limits(const char *text, tl_limits limits[SETPOINT_JOINTS], struct app_error *error) {
  for (int j = 0; j < SETPOINT_JOINTS; j++) limits[j] = tl_limits_none();
  if (limits_read(text, &leg, limits, error) != 0) return -1;
  for (int j = 0; j < SETPOINT_JOINTS; j++)
    if (!isfinite(limits[j].position_low) || !isfinite(limits[j].speed))
      return app_fail(error, APP_BAD_INPUT,
                      "--limits: %s.position and %s.speed are needed to play a trajectory",
                      tl_joint_name(&leg, j), tl_joint_name(&leg, j));
  return 0;
}

/* ---- the check ------------------------------------------------------------------------- */

/* what a row asks of a joint, from itself and from its step to the row before */
struct asked {
  double q, speed, acceleration, torque;
};

static struct asked asked_of(const struct trajectory *t, size_t i, int j) {
  const size_t before = i ? i - 1 : 0;
  const double dt = i ? t->t_s[i] - t->t_s[before] : 1.0;
  const double step = (t->q[j][i] - t->q[j][before]) / dt, speed = trajectory_speed(t, i, j);
  return (struct asked){t->q[j][i], fmax(fabs(speed), fabs(step)),
                        fabs(speed - trajectory_speed(t, before, j)) / dt, fabs(trajectory_torque(t, i, j))};
}

static int broken(const struct trajectory *t, size_t i, int j, const char *what, double value,
                  struct app_error *error) {
  return app_fail(error, APP_BAD_INPUT,
                  "%s: %s.%s is %.6g at time_s %.6g, outside its limit: nothing is sent", t->path,
                  tl_joint_name(&leg, j), what, value, t->begin_s + t->t_s[i]);
}

int setpoints_check(const struct trajectory *t, const tl_limits limits[SETPOINT_JOINTS],
                    struct app_error *error) {
  for (size_t i = 0; i < t->rows; i++)
    for (int j = 0; j < SETPOINT_JOINTS; j++) {
      const struct asked a = asked_of(t, i, j);
      if (a.q < limits[j].position_low || a.q > limits[j].position_high)
        return broken(t, i, j, "position", a.q, error);
      if (a.speed > limits[j].speed) return broken(t, i, j, "speed", a.speed, error);
      if (a.acceleration > limits[j].acceleration)
        return broken(t, i, j, "acceleration", a.acceleration, error);
      if (a.torque > limits[j].torque) return broken(t, i, j, "torque", a.torque, error);
    }
  return 0;
}
