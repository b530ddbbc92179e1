/* hysteresis.c: laws with a memory, stepped along a recorded motion; see talus/experimental/hysteresis.h. */
#include <math.h>
#include <string.h>

#include "talus/experimental/hysteresis.h"
#include "talus/math.h"

#define LARGEST_TURN 0.6 /* rad of the spring's own oscillation in one step */
#define FEWEST_STEPS 4
#define MOST_STEPS 60

/* one step of Dahl's state in the closed form for a constant direction */
static double dahl_step(double z, double move, double travel, double power) {
  double side = move > 0.0 ? 1.0 : -1.0, x = fabs(move) / travel, rest = 1.0 - side * z;

  if (power == 1.0)
    rest *= tl_exp(-x);
  else if (power == 2.0)
    rest /= 1.0 + rest * x;
  else if (rest > 0.0)
    rest = tl_pow(tl_pow(rest, 1.0 - power) + (power - 1.0) * x, 1.0 / (1.0 - power));
  return side * (1.0 - rest);
}

void tl_dahl_along(const double *position, size_t n, double travel, double power, double first,
                   double *state) {
  double z = first;
  size_t k;

  for (k = 0; k < n; k++) {
    if (k > 0) z = dahl_step(z, position[k] - position[k - 1], travel, power);
    state[k] = z;
  }
}

int tl_two_mass_steps(const tl_two_mass *link) {
  double steps = link->step_s * sqrt(link->stiffness_Nm_rad / link->inertia_kg_m2) / LARGEST_TURN;

  if (!(steps > FEWEST_STEPS)) return FEWEST_STEPS;
  return steps > MOST_STEPS ? MOST_STEPS : 2 * ((int)(0.5 * steps) + 1); /* even: halves count alike */
}

/* what changes from step to step, and what does not */
typedef struct {
  double stiffness, half, soft, soft_loss, hardening, damping, h, h_over_inertia, drag_Nm, drag, dry, slow;
  double angle, speed; /* the link's angle less the motor's; the link's speed */
} link_state;

static link_state begin_link(const tl_two_mass *link, double first_Nm, double speed) {
  link_state s;

  s.stiffness = link->stiffness_Nm_rad;
  s.half = 0.5 * link->gap_rad;
  s.soft = link->soft_rad;
  s.soft_loss = link->stiffness_Nm_rad * (1.0 - link->soft_share);
  s.hardening = link->hardening_Nm_rad3;
  s.drag_Nm = link->drag_Nm;
  s.damping = link->damping_s * link->stiffness_Nm_rad;
  s.h = s.h_over_inertia = s.drag = s.dry = s.slow = 0.0;
  s.angle = -first_Nm / link->stiffness_Nm_rad;
  if (first_Nm != 0.0) s.angle += first_Nm > 0.0 ? -s.half : s.half;
  s.speed = speed;
  return s;
}

/* steps of h from now on */
static void set_step(link_state *s, const tl_two_mass *link, double h) {
  double dry = h * link->friction_share / link->inertia_kg_m2,
         viscous = h * link->viscous_share / link->inertia_kg_m2;

  s->h = h;
  s->h_over_inertia = h / link->inertia_kg_m2;
  s->drag = s->h_over_inertia * s->drag_Nm;
  s->dry = dry * (link->coulomb_Nm > 0.0 ? link->coulomb_Nm : 0.0);
  s->slow = 1.0 / (1.0 + viscous * (link->viscous_Nms_rad > 0.0 ? link->viscous_Nms_rad : 0.0));
}

/* torque of the spring by its twist */
static double spring(const link_state *s, double twist) {
  double soft = twist > s->soft ? s->soft : twist < -s->soft ? -s->soft : twist;

  return s->stiffness * twist - s->soft_loss * soft + s->hardening * twist * twist * twist;
}

/* Friction takes the link along with its motor, at the most to the motor's speed; its torque on the link. */
static double drag_link(link_state *s, double motor) {
  double change = motor - s->speed;

  change = change > s->drag ? s->drag : change < -s->drag ? -s->drag : change;
  s->speed += change;
  return change / s->h_over_inertia;
}

/* One step, with motor and load amid it; the spring's torque on the link amid it. Teeth push and do not pull. */
static double step_link(link_state *s, double motor, double load) {
  double beyond, force = 0.0;

  s->angle += 0.5 * s->h * (s->speed - motor);
  beyond = s->angle > s->half ? s->angle - s->half : s->angle < -s->half ? s->angle + s->half : 0.0;
  if (beyond != 0.0) force = -spring(s, beyond) - s->damping * (s->speed - motor);
  if (force * beyond > 0.0) force = 0.0;
  s->speed += s->h_over_inertia * (force - load);
  if (s->drag > 0.0) force += drag_link(s, motor);
  s->speed -= s->speed > s->dry ? s->dry : s->speed < -s->dry ? -s->dry : s->speed;
  s->speed *= s->slow;
  s->angle += 0.5 * s->h * (s->speed - motor);
  return force;
}

/* The motor's speed at a share w of the way: its ends as recorded, and its mean what the angle says. Beside a stop
 * the recorded speeds alone do not carry the motor to the next row. */
static double speed_at(const double v[2], double bulge, double w) {
  return v[0] + w * (v[1] - v[0]) + w * (1.0 - w) * bulge;
}

/* sums over one half of a sample's steps */
typedef struct {
  double torque, speed;
} half_sample;

/* all steps between two samples, in two halves: what is a mean about a sample takes one of either side */
static void step_sample(link_state *s, int count, const double v[2], double bulge, const double load[2],
                        half_sample half[2]) {
  int part;

  memset(half, 0, 2 * sizeof *half);
  for (part = 0; part < count; part++) {
    double w = (part + 0.5) / count, before = s->speed;
    half_sample *h = &half[2 * part >= count];
    h->torque += step_link(s, speed_at(v, bulge, w), load[0] + w * (load[1] - load[0]));
    h->speed += s->speed - before;
  }
}

/* the bulge that carries the motor on by its angle: 6 over what the steps amid [0, 1] make of w (1 - w) */
static double bulge_of(int count, double mean_rad_s, const double v[2]) {
  return 6.0 / (1.0 + 0.5 / ((double)count * count)) * (mean_rad_s - 0.5 * (v[0] + v[1]));
}

/* The link as it is at the first row, with the torque's sum over the half sample before it. What came before is not
 * known, and a wrong begin rings for long: so the recorded motion is run backwards up to there, in which it dies out. */
static link_state settled_link(const tl_two_mass *link, int count, const double *t_s, const double *motor_rad,
                               const double *motor_rad_s, const double *other_Nm, size_t n,
                               double *before_Nm) {
  half_sample half[2] = {{0.0, 0.0}, {0.0, 0.0}};
  link_state s;
  size_t k = 0;

  while (k + 1 < n && t_s[k] - t_s[0] < link->settle_s) k++;
  s = k > 0 ? begin_link(link, other_Nm[k], -motor_rad_s[k])
            : begin_link(link, 0.0, n ? -motor_rad_s[0] : 0.0);
  for (; k > 0; k--) {
    const double back[2] = {-motor_rad_s[k], -motor_rad_s[k - 1]}, load[2] = {other_Nm[k], other_Nm[k - 1]};
    double h = t_s[k] - t_s[k - 1];
    set_step(&s, link, h / count);
    step_sample(&s, count, back, bulge_of(count, (motor_rad[k - 1] - motor_rad[k]) / h, back), load, half);
  }
  *before_Nm = half[1].torque;
  s.speed = -s.speed;
  return s;
}

void tl_two_mass_along(const tl_two_mass *link, const double *t_s, const double *motor_rad,
                       const double *motor_rad_s, const double *other_Nm, size_t n, tl_two_mass_motion *out) {
  int count = tl_two_mass_steps(link);
  half_sample half[2], before = {0.0, 0.0};
  link_state s = settled_link(link, count, t_s, motor_rad, motor_rad_s, other_Nm, n, &before.torque);
  double h, before_s = 0.0;
  size_t k;

  for (k = 0; k + 1 < n; k++) {
    out->angle_rad[k] = s.angle;
    h = t_s[k + 1] - t_s[k];
    set_step(&s, link, h / count);
    step_sample(&s, count, &motor_rad_s[k],
                bulge_of(count, (motor_rad[k + 1] - motor_rad[k]) / h, &motor_rad_s[k]), &other_Nm[k], half);
    out->torque_Nm[k] = (before.torque + half[0].torque) / count;
    out->link_rad_s2[k] = 2.0 * (before.speed + half[0].speed) / (k > 0 ? before_s + h : h);
    before = half[1];
    before_s = h;
  }
  if (n == 0) return;
  out->angle_rad[k] = s.angle;
  out->torque_Nm[k] = 2.0 * before.torque / count;
  out->link_rad_s2[k] = before_s > 0.0 ? 2.0 * before.speed / before_s : 0.0;
}
