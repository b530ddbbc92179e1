/* orders.c: see orders.h. */
#include "orders.h"

#include <math.h>
#include <string.h>

#include "talus/transmission.h"

#define PATIENCE_S 0.1 /* without a set-point, or a heartbeat where there was one: hold */
#define HALF_MOVE_S 0.5

void orders_rest(tl_excitation *e, int joints) {
  memset(e, 0, sizeof *e);
  e->kind = TL_EXCITATION_RAMPS;
  e->joints = joints;
  e->base_hz = 1.0;
  e->moves = 1;
  e->move[0].duration_s = 2.0 * HALF_MOVE_S;
}

void orders_init(struct orders *o, const tl_model *m, const tl_twin_settings *bench, const tl_limits *limits,
                 int follow) {
  memset(o, 0, sizeof *o);
  o->model = m;
  o->bench = bench;
  o->limits = limits;
  o->follow = follow;
  o->state = follow ? LEG_BUS_HOLD : LEG_BUS_FOLLOW;
}

static void keep_within(struct orders *o, int joint, double *q_rad) {
  const tl_limits *limit = &o->limits[joint];

  if (*q_rad >= limit->position_low && *q_rad <= limit->position_high) return;
  *q_rad = *q_rad < limit->position_low ? limit->position_low : limit->position_high;
  o->clamped++;
}

void orders_take(struct orders *o, const struct leg_bus_frame *frame) {
  struct leg_bus_setpoint setpoint;
  int joint;

  if (leg_bus_is_stop(frame)) o->state = LEG_BUS_STOPPED;
  if (!o->follow) return;
  if (leg_bus_unpack_host_heartbeat(frame, &o->asked) == 0) {
    o->has_heartbeat = 1;
    o->heartbeat_age = 0;
  }
  if (leg_bus_unpack_command(frame, &joint, &setpoint) != 0) return;
  keep_within(o, joint, &setpoint.q_rad);
  o->last[joint] = setpoint;
  o->fresh[joint] = o->begun = 1;
  o->command_age = 0;
  o->taken++;
}

/* what the bench does at this tick */
static void choose_state(struct orders *o) {
  const unsigned long patience = (unsigned long)(PATIENCE_S * o->bench->control_hz);
  const int obeys = o->has_heartbeat;

  if (!o->follow || o->state == LEG_BUS_STOPPED) return;
  if (obeys && o->asked == LEG_BUS_OFF)
    o->state = LEG_BUS_OFF;
  else if (!o->begun || o->command_age > patience || (obeys && o->heartbeat_age > patience) ||
           (obeys && o->asked == LEG_BUS_HOLD))
    o->state = LEG_BUS_HOLD;
  else
    o->state = LEG_BUS_FOLLOW;
  if (o->state == LEG_BUS_FOLLOW && !(o->fresh[0] && o->fresh[1])) o->missed++;
  o->fresh[0] = o->fresh[1] = 0;
  o->command_age++;
  o->heartbeat_age++;
}

/* the set-point's angle and speed, shifted by what makes its torque */
static void reference_of(const struct orders *o, int joint, double *q, double *v) {
  const tl_transmission *t = &o->model->drive[joint].transmission;
  const double most = o->bench->current_limit_A[joint];
  double current = o->last[joint].torque_Nm / o->model->drive[joint].torque_constant_Nm_A, before, after,
         slope;

  *q = o->last[joint].q_rad;
  *v = o->last[joint].v_rad_s;
  if (current == 0.0 || !(o->bench->stiffness[joint] > 0.0)) return;
  current = current > most ? most : current < -most ? -most : current;
  tl_transmission_ratio(t, *q, &before, &slope);
  *q = tl_transmission_joint_angle(t,
                                   tl_transmission_motor_angle(t, *q) + current / o->bench->stiffness[joint]);
  tl_transmission_ratio(t, *q, &after, &slope);
  *v *= before / after;
}

void orders_apply(struct orders *o, double t_s, tl_excitation *e, tl_twin *b) {
  tl_move *move = &e->move[0];
  int powered, j;

  choose_state(o);
  powered = o->state == LEG_BUS_HOLD || o->state == LEG_BUS_FOLLOW;
  for (j = 0; j < TL_MAX_JOINTS; j++) {
    b->settings.stiffness[j] = powered ? o->bench->stiffness[j] : 0.0;
    b->settings.damping[j] = powered ? o->bench->damping[j] : 0.0;
  }
  if (!o->follow) return;
  move->begin_s = t_s - HALF_MOVE_S;
  for (j = 0; j < TL_MAX_JOINTS; j++) {
    double q = o->last[j].q_rad, v = 0.0;
    if (o->state == LEG_BUS_FOLLOW) reference_of(o, j, &q, &v);
    move->from[j] = q - HALF_MOVE_S * v;
    move->to[j] = q + HALF_MOVE_S * v;
  }
}
