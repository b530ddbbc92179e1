/* setpoints_limits.c: limits as they are given, and a trajectory against them. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "common/decimal.h"
#include "setpoints.h"

static const char *const joint_name[SETPOINT_JOINTS] = {"knee", "ankle"};

/* ---- "knee.position=-0.9:0.1,knee.speed=4" --------------------------------------------- */

static int take_number(const char **text, double *value) {
  const char *end;
  if (decimal_parse(*text, value, &end) != DECIMAL_OK) return 0;
  *text = end;
  return 1;
}

static int take_position(const char **text, tl_limits *limit) {
  if (!take_number(text, &limit->position_low) || **text != ':') return 0;
  ++*text;
  return take_number(text, &limit->position_high) && limit->position_low < limit->position_high;
}

/* one limit at *text, which moves behind it */
static int take_limit(const char **text, tl_limits limits[SETPOINT_JOINTS]) {
  static const struct {
    const char *name;
    size_t offset;
  } quantity[] = {{".speed=", offsetof(tl_limits, speed)},
                  {".acceleration=", offsetof(tl_limits, acceleration)},
                  {".torque=", offsetof(tl_limits, torque)}};
  for (int j = 0; j < SETPOINT_JOINTS; j++) {
    const size_t n = strlen(joint_name[j]);
    if (strncmp(*text, joint_name[j], n) != 0) continue;
    const char *rest = *text + n;
    if (strncmp(rest, ".position=", 10) == 0) return *text = rest + 10, take_position(text, &limits[j]);
    for (size_t q = 0; q < sizeof quantity / sizeof quantity[0]; q++) {
      double *value = (double *)(void *)((char *)&limits[j] + quantity[q].offset);
      if (strncmp(rest, quantity[q].name, strlen(quantity[q].name)) != 0) continue;
      *text = rest + strlen(quantity[q].name);
      return take_number(text, value) && *value > 0.0;
    }
  }
  return 0;
}

int setpoints_limits(const char *text, tl_limits limits[SETPOINT_JOINTS], struct app_error *error) {
  const char *at = text;
  for (int j = 0; j < SETPOINT_JOINTS; j++) limits[j] = tl_limits_none();
  while (*at) {
    const char *here = at;
    if (!take_limit(&at, limits) || (*at && *at != ','))
      return app_fail(
          error, APP_BAD_INPUT,
          "--limits: expected for instance knee.position=-0.9:0.1 or ankle.speed=4, found '%.40s'", here);
    at += *at == ',';
  }
  for (int j = 0; j < SETPOINT_JOINTS; j++)
    if (!isfinite(limits[j].position_low) || !isfinite(limits[j].speed))
      return app_fail(error, APP_BAD_INPUT,
                      "--limits: %s.position and %s.speed are needed to play a trajectory", joint_name[j],
                      joint_name[j]);
  return 0;
}

/* ---- the check ------------------------------------------------------------------------- */

/* what a row asks of a joint, from itself and from its step to the row before */
struct asked {
  double q, speed, acceleration, torque;
};

static struct asked asked_of(const struct setpoints *t, size_t i, int j) {
  const struct setpoint *now = &t->row[i], *before = &t->row[i ? i - 1 : 0];
  const double dt = i ? now->t_s - before->t_s : 1.0;
  const double step = (now->joint[j].q_rad - before->joint[j].q_rad) / dt;
  return (struct asked){now->joint[j].q_rad, fmax(fabs(now->joint[j].v_rad_s), fabs(step)),
                        fabs(now->joint[j].v_rad_s - before->joint[j].v_rad_s) / dt,
                        fabs(now->joint[j].torque_Nm)};
}

static int broken(const struct setpoints *t, size_t i, int j, const char *what, double value,
                  struct app_error *error) {
  return app_fail(error, APP_BAD_INPUT,
                  "%s: %s.%s is %.6g at time_s %.6g, outside its limit: nothing is sent", t->path,
                  joint_name[j], what, value, t->row[i].t_s);
}

int setpoints_check(const struct setpoints *t, const tl_limits limits[SETPOINT_JOINTS],
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
