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

static inline double elastic_of(const tl_spring *s, double twist) {
  double soft = twist > s->soft_rad ? s->soft_rad : twist < -s->soft_rad ? -s->soft_rad : twist;

  return s->stiffness_Nm_rad * (twist - (1.0 - s->soft_share) * soft) +
         s->hardening_Nm_rad3 * twist * twist * twist;
}

double tl_spring_elastic(const tl_spring *s, double twist) {
  return elastic_of(s, twist);
}

/* what is left of an angle beyond half the gap */
static double beyond_gap(double angle, double half) {
  return angle > half ? angle - half : angle < -half ? angle + half : 0.0;
}

double tl_spring_torque(const tl_spring *s, double twist_rad, double rate_rad_s, double *loss_W) {
  double twist = beyond_gap(twist_rad, 0.5 * s->gap_rad), damping = s->damping_Nms_rad * rate_rad_s, torque;

  if (s->gap_rad > 0.0 && twist == 0.0) return 0.0;
  torque = elastic_of(s, twist) + damping;
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
  double elastic = -elastic_of(&s->spring, beyond), damping = s->spring.damping_Nms_rad;
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

/* One link between two samples. A step waits for the one before it, and each of its sums for the last: several links that
 * take their steps in turn fill each other's waiting, and each is the same to the bit as alone. */
typedef struct {
  const tl_two_mass_run *run;
  size_t row;
  link_state s;
  link_step step;
  double h_s, v[2], load[2], bulge, load_bulge;
  half_sample half[2], before;
  double before_s;
} link_lane;

/* to be done with a sample: `back` from the row `from` to the one before it, its speeds the other way */
static void set_sample(link_lane *lane, int count, size_t from, int back) {
  const tl_two_mass_run *r = lane->run;
  size_t to = back ? from - 1 : from + 1, first = back ? to : from;
  double side = back ? -1.0 : 1.0;

  lane->h_s = r->t_s[first + 1] - r->t_s[first];
  set_row(&lane->s, &r->link, first);
  if (back) lane->s.load_damping = -lane->s.load_damping;
  lane->v[0] = side * r->motor_rad_s[from];
  lane->v[1] = side * r->motor_rad_s[to];
  lane->load[0] = r->other_Nm[from];
  lane->load[1] = r->other_Nm[to];
  lane->bulge = speed_bulge(count, (r->motor_rad[to] - r->motor_rad[from]) / lane->h_s, lane->v);
  lane->load_bulge = bulge_of(count, lane->s.load_bulge);
  lane->step = step_of(&lane->s, lane->h_s / count);
  memset(lane->half, 0, sizeof lane->half);
}

/* all steps between two samples, in two halves: what is a mean about a sample takes one of either side */
static void step_sample(link_lane *const *lane, int lanes, int count) {
  int part, k;

  for (part = 0; part < count; part++) {
    double amid = (part + 0.5) / count, end = (part + 1.0) / count;
    for (k = 0; k < lanes; k++) {
      link_lane *l = lane[k];
      double before = l->s.speed;
      motor_speed motor = {value_at(l->v, l->bulge, amid), value_at(l->v, l->bulge, end)};
      half_sample *half = &l->half[2 * part >= count];
      half->torque += step_link(&l->s, &l->step, motor, value_at(l->load, l->load_bulge, amid));
      half->speed += l->s.speed - before;
    }
  }
}

/* The link as it is at the first row, with the torque's sum over the half sample before it. What came before is not
 * known, and a wrong begin rings for long: so the recorded motion is run backwards up to there, in which it dies out. */
static void begin_settling(link_lane *lane, const tl_two_mass_run *run) {
  size_t k = 0;

  memset(lane, 0, sizeof *lane);
  lane->run = run;
  while (k + 1 < run->n && run->t_s[k] - run->t_s[0] < run->link.settle_s) k++;
  lane->row = k;
  lane->s = begin_link(&run->link, k > 0 ? run->other_Nm[k] : 0.0, run->n ? -run->motor_rad_s[k] : 0.0);
}

static void settle(link_lane *lane, int lanes, int count) {
  link_lane *left[TL_TWO_MASS_LANES];
  int k, settling;

  do {
    for (k = settling = 0; k < lanes; k++)
      if (lane[k].row > 0) left[settling++] = &lane[k];
    for (k = 0; k < settling; k++) set_sample(left[k], count, left[k]->row--, 1);
    step_sample(left, settling, count);
  } while (settling > 0);
  for (k = 0; k < lanes; k++) {
    lane[k].before.torque = lane[k].half[1].torque;
    lane[k].s.speed = -lane[k].s.speed;
  }
}

/* what a sample's steps left, at its first row */
static void tell_sample(link_lane *lane, int count, size_t k) {
  const tl_two_mass_motion *out = &lane->run->out;
  double h = lane->h_s;

  out->torque_Nm[k] = (lane->before.torque + lane->half[0].torque) / count;
  out->link_rad_s2[k] =
      2.0 * (lane->before.speed + lane->half[0].speed) / (k > 0 ? lane->before_s + h : h);
  lane->before = lane->half[1];
  lane->before_s = h;
}

static void tell_last(const link_lane *lane, int count) {
  const tl_two_mass_motion *out = &lane->run->out;
  size_t k = lane->run->n;

  if (k-- == 0) return;
  out->angle_rad[k] = lane->s.angle;
  out->torque_Nm[k] = 2.0 * lane->before.torque / count;
  out->link_rad_s2[k] = lane->before_s > 0.0 ? 2.0 * lane->before.speed / lane->before_s : 0.0;
}

static void run_forward(link_lane *lane, int lanes, int count) {
  link_lane *left[TL_TWO_MASS_LANES];
  int k, running;
  size_t row = 0;

  do {
    for (k = running = 0; k < lanes; k++)
      if (row + 1 < lane[k].run->n) left[running++] = &lane[k];
    for (k = 0; k < running; k++) {
      left[k]->run->out.angle_rad[row] = left[k]->s.angle;
      set_sample(left[k], count, row, 0);
    }
    step_sample(left, running, count);
    for (k = 0; k < running; k++) tell_sample(left[k], count, row);
    row++;
  } while (running > 0);
}

void tl_two_mass_along_each(const tl_two_mass_run *run, size_t runs) {
  link_lane lane[TL_TWO_MASS_LANES];
  size_t first, next;
  int count, k, lanes;

  for (first = 0; first < runs; first = next) {
    count = tl_two_mass_steps(&run[first].link);
    lanes = 0;
    for (next = first; next < runs && lanes < TL_TWO_MASS_LANES; next++) {
      if (tl_two_mass_steps(&run[next].link) != count) break;
      begin_settling(&lane[lanes++], &run[next]);
    }
    settle(lane, lanes, count);
    run_forward(lane, lanes, count);
    for (k = 0; k < lanes; k++) tell_last(&lane[k], count);
  }
}

void tl_two_mass_along(const tl_two_mass *link, const double *t_s, const double *motor_rad,
                       const double *motor_rad_s, const double *other_Nm, size_t n, tl_two_mass_motion *out) {
  tl_two_mass_run run = {*link, t_s, motor_rad, motor_rad_s, other_Nm, n, *out};

  tl_two_mass_along_each(&run, 1);
}
