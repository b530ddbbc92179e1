/* stepped.c: laws with a memory, stepped along a recorded motion; see talus/gap.h. */
#include <math.h>

#include "talus/gap.h"
#include "talus/math.h"

#define LARGEST_TURN 0.4  /* rad of the spring's own oscillation in one step */
#define DAMPING_RATIO 0.1 /* of the spring: metal gears, and enough for the free motion to die out */
#define FEWEST_STEPS 4
#define MOST_STEPS 60

/* one step of Dahl's state in the closed form for a constant direction */
static double dahl_step(double z, double move, double travel, int squared) {
  double side = move > 0.0 ? 1.0 : -1.0, x = fabs(move) / travel, rest = 1.0 - side * z;

  rest = squared ? rest / (1.0 + rest * x) : rest * tl_exp(-x);
  return side * (1.0 - rest);
}

void tl_gap_dahl(const double *position, size_t n, double travel, int squared, double *state) {
  double z = 0.0;
  size_t k;

  for (k = 0; k < n; k++) {
    if (k > 0) z = dahl_step(z, position[k] - position[k - 1], travel, squared);
    state[k] = z;
  }
}

int tl_gap_link_steps(const tl_gap_link *link) {
  double steps = link->step_s * sqrt(link->stiffness_Nm_rad / link->inertia_kg_m2) / LARGEST_TURN;

  if (!(steps > FEWEST_STEPS)) return FEWEST_STEPS;
  return steps > MOST_STEPS ? MOST_STEPS : (int)steps + 1;
}

/* what changes from step to step, and what does not */
typedef struct {
  double stiffness, half, damping, dry, slow, h, h_over_inertia;
  double angle, speed; /* the link's angle less the motor's; the link's speed */
} link_state;

static link_state begin_link(const tl_gap_link *link, double speed) {
  link_state s;
  double share = link->friction_share / link->inertia_kg_m2;

  s.stiffness = link->stiffness_Nm_rad;
  s.half = 0.5 * link->gap_rad;
  s.damping = 2.0 * DAMPING_RATIO * sqrt(link->stiffness_Nm_rad * link->inertia_kg_m2);
  s.h = link->step_s / tl_gap_link_steps(link);
  s.h_over_inertia = s.h / link->inertia_kg_m2;
  s.dry = s.h * share * (link->coulomb_Nm > 0.0 ? link->coulomb_Nm : 0.0);
  s.slow = 1.0 / (1.0 + s.h * share * (link->viscous_Nms_rad > 0.0 ? link->viscous_Nms_rad : 0.0));
  s.angle = 0.0;
  s.speed = speed;
  return s;
}

/* One step; the spring's torque on the link. Teeth push and do not pull. */
static double step_link(link_state *s, double motor, double load) {
  double beyond = s->angle > s->half ? s->angle - s->half : s->angle < -s->half ? s->angle + s->half : 0.0;
  double force = 0.0;

  if (beyond != 0.0) force = -s->stiffness * beyond - s->damping * (s->speed - motor);
  if (force * beyond > 0.0) force = 0.0;
  s->speed += s->h_over_inertia * (force - load);
  s->speed -= s->speed > s->dry ? s->dry : s->speed < -s->dry ? -s->dry : s->speed;
  s->speed *= s->slow;
  s->angle += s->h * (s->speed - motor);
  return force;
}

void tl_gap_link_along(const tl_gap_link *link, const double *motor_rad_s, const double *other_Nm, size_t n,
                       double *angle_rad, double *torque_Nm) {
  int count = tl_gap_link_steps(link), part;
  link_state s = begin_link(link, n > 0 ? motor_rad_s[0] : 0.0);
  size_t k;

  for (k = 0; k < n; k++) {
    size_t from = k > 0 ? k - 1 : 0;
    double total = 0.0;
    for (part = 0; part < count; part++) {
      double w = (part + 0.5) / count;
      total += step_link(&s, motor_rad_s[from] + w * (motor_rad_s[k] - motor_rad_s[from]),
                         other_Nm[from] + w * (other_Nm[k] - other_Nm[from]));
    }
    angle_rad[k] = s.angle;
    torque_Nm[k] = total / count;
  }
}
