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

double tl_dahl_rate(double v, double z, double travel, double power) {
  double rest = v < 0.0 ? 1.0 + z : 1.0 - z;

  if (power > 1.0) rest = rest > 0.0 ? tl_pow(rest, power) : 0.0;
  return v * rest / travel;
}

/* ---- a transmission that twists ------------------------------------------------------ */

double tl_spring_elastic(const tl_spring *s, double twist) {
  double soft = twist > s->soft_rad ? s->soft_rad : twist < -s->soft_rad ? -s->soft_rad : twist;

  return s->stiffness_Nm_rad * (twist - (1.0 - s->soft_share) * soft) +
         s->hardening_Nm_rad3 * twist * twist * twist;
}

/* what is left of an angle beyond half the gap */
static double beyond_gap(double angle, double half) {
  return angle > half ? angle - half : angle < -half ? angle + half : 0.0;
}

double tl_spring_torque(const tl_spring *s, double twist_rad, double rate_rad_s, double *loss_W) {
  double twist = beyond_gap(twist_rad, 0.5 * s->gap_rad), damping = s->damping_Nms_rad * rate_rad_s, torque;

  if (s->gap_rad > 0.0 && twist == 0.0) return 0.0;
  torque = tl_spring_elastic(s, twist) + damping;
  if (s->gap_rad > 0.0 && !(torque * twist > 0.0)) return 0.0;
  *loss_W += damping * rate_rad_s;
  return torque;
}

/* ---- a link beyond it, along its motor's motion ---------------------------------------- */

/* what changes from row to row and from step to step, and what does not */
typedef struct {
  tl_spring spring;
  double half, drag_Nm; /* of the gap */
  /* of a row */
  double inertia, dry_Nm, viscous_Nms_rad;
  double load_bulge, load_stiffness, load_damping; /* as tl_two_mass has them */
  /* the link's angle less the motor's; the link's speed */
  double angle, speed;
} link_state;

/* a step's length, and what follows from it */
typedef struct {
  double h, h_over_inertia, drag, dry, slow, grip;
} link_step;

static link_state begin_link(const tl_two_mass *link, double first_Nm, double speed) {
  link_state s;

  memset(&s, 0, sizeof s);
  s.spring.stiffness_Nm_rad = link->stiffness_Nm_rad;
  s.spring.soft_rad = link->soft_rad;
  s.spring.soft_share = link->soft_share;
  s.spring.hardening_Nm_rad3 = link->hardening_Nm_rad3;
  s.spring.damping_Nms_rad = link->damping_s * link->stiffness_Nm_rad;
  s.half = 0.5 * link->gap_rad;
  s.drag_Nm = link->drag_Nm;
  s.angle = -first_Nm / link->stiffness_Nm_rad;
  if (first_Nm != 0.0) s.angle += first_Nm > 0.0 ? -s.half : s.half;
  s.speed = speed;
  return s;
}

static double amid(const double *x, size_t k, double otherwise) {
  return x ? 0.5 * (x[k] + x[k + 1]) : otherwise;
}

/* from now on between rows k and k + 1 */
static void set_row(link_state *s, const tl_two_mass *link, size_t k) {
  s->inertia = amid(link->row_inertia_kg_m2, k, link->inertia_kg_m2);
  s->load_bulge = link->row_bulge_Nm ? link->row_bulge_Nm[k] : 0.0;
  s->load_stiffness = amid(link->row_stiffness_Nm_rad, k, 0.0);
  s->load_damping = amid(link->row_damping_Nms_rad, k, 0.0);
  s->dry_Nm = link->coulomb_Nm > 0.0 ? link->friction_share * link->coulomb_Nm : 0.0;
  s->viscous_Nms_rad = link->viscous_Nms_rad > 0.0 ? link->viscous_share * link->viscous_Nms_rad : 0.0;
}

static link_step step_of(const link_state *s, double h) {
  link_step step = {.h = h, .h_over_inertia = h / s->inertia};

  step.drag = step.h_over_inertia * s->drag_Nm;
  step.dry = step.h_over_inertia * s->dry_Nm;
  step.slow = 1.0 / (1.0 + step.h_over_inertia * s->viscous_Nms_rad);
  step.grip = 1.0 / (1.0 + 0.5 * step.h_over_inertia * s->spring.damping_Nms_rad);
  return step;
}

/* The motor's speed over a step: amid it, and at its end. */
typedef struct {
  double amid, end;
} motor_speed;

/* Friction takes the link along with its motor, at the most to the speed that the motor ends the step with: a link that kept
 * to the speed amid the step would fall behind by half a step of every change of speed. Its torque on the link. */
static double drag_link(link_state *s, const link_step *step, double motor) {
  double change = motor - s->speed;

  change = change > step->drag ? step->drag : change < -step->drag ? -step->drag : change;
  s->speed += change;
  return change / step->h_over_inertia;
}

/* The link's speed amid a step but for the spring's push. */
static double speed_amid(const link_state *s, const link_step *step, double load) {
  if (s->dry_Nm > 0.0 && s->speed != 0.0) load += s->speed > 0.0 ? s->dry_Nm : -s->dry_Nm;
  return s->speed - 0.5 * step->h_over_inertia * (load + s->viscous_Nms_rad * s->speed);
}

/* The spring's torque on the link by tl_spring_torque's law; its damping taken amid the step, where the push has given
 * the link half its speed: force = elastic - damping (speed amid + h / 2 I force - motor). A link at rest may stay so. */
static double contact(const link_state *s, const link_step *step, double beyond, double motor, double load) {
  double elastic = -tl_spring_elastic(&s->spring, beyond), damping = s->spring.damping_Nms_rad;
  double force = elastic + damping * motor;

  if (s->speed != 0.0 || fabs(force - load) > s->dry_Nm)
    force = (elastic - damping * (speed_amid(s, step, load) - motor)) * step->grip;
  return s->half > 0.0 && force * beyond > 0.0 ? 0.0 : force;
}

/* One step, with the load amid it; the spring's torque on the link amid it. */
static double step_over(link_state *s, const link_step *step, motor_speed speed, double load) {
  double motor = speed.amid, beyond, force = 0.0;

  s->angle += 0.5 * step->h * (s->speed - motor);
  beyond = beyond_gap(s->angle, s->half);
  load += s->load_stiffness * s->angle + s->load_damping * (s->speed - motor);
  if (beyond != 0.0) force = contact(s, step, beyond, motor, load);
  s->speed += step->h_over_inertia * (force - load);
  if (step->drag > 0.0) force += drag_link(s, step, speed.end);
  s->speed -= s->speed > step->dry ? step->dry : s->speed < -step->dry ? -step->dry : s->speed;
  s->speed *= step->slow;
  s->angle += 0.5 * step->h * (s->speed - motor);
  return force;
}

/* the share of a step after which the teeth meet or part; 0 if they do not */
static double meeting(const link_state *s, double h, double motor) {
  double end = s->angle + h * (s->speed - motor), share;
  int apart = fabs(s->angle) < s->half;

  if (apart == (fabs(end) < s->half)) return 0.0;
  share = ((end + s->angle > 0.0 ? s->half : -s->half) - s->angle) / (end - s->angle);
  return share > 0.01 && share < 0.99 ? share : 0.0;
}

/* A step in which teeth meet or part is cut there: a push for the rest of it alone. */
static double step_link(link_state *s, const link_step *step, motor_speed motor, double load) {
  double share = s->half > 0.0 ? meeting(s, step->h, motor.amid) : 0.0, force;
  motor_speed first = {motor.amid, motor.amid + (2.0 * share - 1.0) * (motor.end - motor.amid)};
  link_step part;

  if (share == 0.0) return step_over(s, step, motor, load);
  part = step_of(s, share * step->h);
  force = share * step_over(s, &part, first, load);
  part = step_of(s, (1.0 - share) * step->h);
  return force + (1.0 - share) * step_over(s, &part, motor, load);
}

/* A value at a share w of the way: its ends as recorded, and its mean as that is known. A motor's is what the angle says:
 * beside a stop the recorded speeds alone do not carry it to the next row. */
static double value_at(const double ends[2], double bulge, double w) {
  return ends[0] + w * (ends[1] - ends[0]) + w * (1.0 - w) * bulge;
}

/* the bulge that lifts the mean above the ends' by so much: 6 over what the steps amid [0, 1] make of w (1 - w) */
static double bulge_of(int count, double above) {
  return 6.0 / (1.0 + 0.5 / ((double)count * count)) * above;
}

/* of the motor's speed, from the angle that it goes */
static double speed_bulge(int count, double mean_rad_s, const double v[2]) {
  return bulge_of(count, mean_rad_s - 0.5 * (v[0] + v[1]));
}

/* sums over one half of a sample's steps */
typedef struct {
  double torque, speed;
} half_sample;

/* all steps between two samples, in two halves: what is a mean about a sample takes one of either side */
static void step_sample(link_state *s, int count, double h_s, const double v[2], double bulge,
                        const double load[2], half_sample half[2]) {
  link_step step = step_of(s, h_s / count);
  double load_bulge = bulge_of(count, s->load_bulge);
  int part;

  memset(half, 0, 2 * sizeof *half);
  for (part = 0; part < count; part++) {
    double w = (part + 0.5) / count, before = s->speed;
    motor_speed motor = {value_at(v, bulge, w), value_at(v, bulge, (part + 1.0) / count)};
    half_sample *h = &half[2 * part >= count];
    h->torque += step_link(s, &step, motor, value_at(load, load_bulge, w));
    h->speed += s->speed - before;
  }
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
    set_row(&s, link, k - 1);
    s.load_damping = -s.load_damping;
    step_sample(&s, count, h, back, speed_bulge(count, (motor_rad[k - 1] - motor_rad[k]) / h, back), load,
                half);
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
    set_row(&s, link, k);
    step_sample(&s, count, h, &motor_rad_s[k],
                speed_bulge(count, (motor_rad[k + 1] - motor_rad[k]) / h, &motor_rad_s[k]), &other_Nm[k],
                half);
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
