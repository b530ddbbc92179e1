/* twin_laws.c: what acts in and beside a joint; each law in several published forms */
#include "twin.h"

#include <math.h>

#define PI 3.14159265358979323846

static double sign(double x) {
  return x > 0.0 ? 1.0 : (x < 0.0 ? -1.0 : 0.0);
}

static double waves(const double *order, const double *size, const double *phase, double x) {
  double sum = 0.0;
  int i;

  for (i = 0; i < MAX_WAVES; i++)
    if (size[i] != 0.0) sum += size[i] * sin(order[i] * x + phase[i]);
  return sum;
}

double twin_joint_angle(const double *q, int joint) {
  return joint == KNEE ? q[SHANK] - q[PHI] : q[FOOT] - q[SHANK];
}

int twin_flexible(const twin_joint *j) {
  return j->elastic_form > 0.0;
}

/* Friction at near-standstill above Coulomb's: exponential, Gaussian, Lorentzian, difference of two tanh, or of any power. */
static double stribeck(const twin_joint *j, double speed) {
  double x = speed / j->stribeck_speed;

  switch ((int)j->stribeck_form) {
  case 1: return j->stribeck_extra * exp(-x);
  case 2: return j->stribeck_extra * exp(-x * x);
  case 3: return j->stribeck_extra / (1.0 + pow(x, j->stribeck_power));
  case 4: return j->stribeck_extra * (1.0 - tanh(x));
  case 5: return j->stribeck_extra * exp(-pow(x, j->stribeck_power));
  default: return 0.0;
  }
}

static double by_load(const twin_joint *j, const twin_state *s, int joint) {
  double load = s->load[joint];

  switch ((int)j->load_form) {
  case 1: return j->load_coef * fabs(load);
  case 2: return j->load_coef * (sqrt(load * load + j->load_ref * j->load_ref) - j->load_ref);
  case 3: return j->load_coef * fabs(s->load_all[joint]);
  case 4: return j->load_coef * load * load / j->load_ref;
  default: return 0.0;
  }
}

/* Losses in proportion to power; they differ with its direction. An efficiency is the load over the motor's torque when driving,
 * the motor's torque over the load when back-driven. */
static double by_power(const twin_joint *j, const twin_state *s, int joint, double slip) {
  int of_motor = j->eff_form > 1.5;
  double load = of_motor ? s->load_all[joint] : s->load[joint], driving = load * slip;
  double lost_driving = of_motor ? 1.0 - j->eff_driving : 1.0 / j->eff_driving - 1.0;
  double lost_back = of_motor ? 1.0 / j->eff_back - 1.0 : 1.0 - j->eff_back;
  double part =
      j->eff_smooth > 0.0 ? 0.5 * (1.0 + tanh(driving / j->eff_smooth)) : (driving > 0.0 ? 1.0 : 0.0);

  if (j->eff_form <= 0.0) return 0.0;
  return fabs(load) * (part * lost_driving + (1.0 - part) * lost_back);
}

static double by_position(const twin_joint *j, double q) {
  double x = (q - j->pos_centre) / j->pos_width;

  switch ((int)j->pos_form) {
  case 1: return j->pos_size * sin(x + j->pos_phase);
  case 2: return j->pos_size * x;
  case 3: return j->pos_size * exp(-x * x);
  case 4: return j->pos_size * (x * x - 0.33);
  case 5: return j->pos_size * (0.7 * x - 0.5 * x * x * x);
  case 6: return j->pos_size * tanh(3.0 * x);
  default: return 0.0;
  }
}

static double drift(const twin_bench *b, const twin_joint *j, double t) {
  double session = t + b->session_s, since = j->drift_session > 0.5 ? session : t;

  if (since < 0.0 && j->drift_session < 0.5) since = 0.0;
  switch ((int)j->drift_form) {
  case 1: return 1.0 + j->drift_size * exp(-since / j->drift_tau);
  case 2: return 1.0 + j->drift_size * fmin(since / j->drift_tau, 1.0); /* friction, not a drive, however long it takes */
  case 3: return 1.0 + j->drift_size * (1.0 - exp(-session / b->temp_tau));
  case 4: return 1.0 + j->drift_size / (1.0 + since / j->drift_tau);
  default: return 1.0;
  }
}

static double drift_of(const twin_bench *b, const twin_joint *j, double t, int viscous) {
  int on = (int)j->drift_on;

  return on == 0 || (on == 1 && !viscous) || (on == 2 && viscous) ? drift(b, j, t) : 1.0;
}

/* The level at which dry friction gives way or slides, against slip in the direction `slip`. */
double twin_dry(const twin_bench *b, const twin_state *s, int joint, double t, double slip) {
  const twin_joint *j = &b->joint[joint];
  double v = s->v[joint == KNEE ? DRIVE_K : DRIVE_A], q = s->q[joint == KNEE ? DRIVE_K : DRIVE_A];
  double other = twin_joint_angle(s->q, 1 - joint), level = j->coulomb * (1.0 - j->pre_share);

  level += stribeck(j, fabs(v)) + by_load(j, s, joint) + by_power(j, s, joint, slip) + by_position(j, q);
  level += slip * j->asym_coulomb;
  if (j->cross_size != 0.0) level += j->cross_size * sin(other / j->cross_width + j->cross_phase);
  level *= drift_of(b, j, t, 0) * (1.0 + s->walk[joint]);
  return level > 0.0 ? level : 0.0;
}

/* Friction that needs no sign: viscous of every kind [Nm against the motion]. */
double twin_smooth_friction(const twin_bench *b, const twin_state *s, int joint, double t) {
  const twin_joint *j = &b->joint[joint];
  double v = s->v[joint == KNEE ? DRIVE_K : DRIVE_A], x = v / (j->nlv_speed > 0.0 ? j->nlv_speed : 1.0),
         more = 0.0;

  switch ((int)j->nlv_form) {
  case 1: more = sign(x) * pow(fabs(x), j->nlv_power); break;
  case 2: more = x * fabs(x); break;
  case 3: more = tanh(x); break;
  case 4: more = x * x * x; break;
  case 5: more = x / (1.0 + fabs(x)); break;
  case 6: more = atan(x); break;
  default: break;
  }
  return (j->viscous * v + j->asym_viscous * fabs(v) + j->nlv_size * more) * drift_of(b, j, t, 1);
}

/* Dry friction with memory [Nm against the motion]: Dahl, LuGre, or five elastoplastic elements in parallel. */
double twin_memory(const twin_bench *b, twin_state *s, int joint) {
  const twin_joint *j = &b->joint[joint];
  double v = s->v[joint == KNEE ? DRIVE_K : DRIVE_A], way = v * b->step_s, full = j->coulomb * j->pre_share,
         g, sum = 0.0;
  double *z = s->z[joint];
  int i;

  switch ((int)j->pre_form) {
  case 1: { /* Dahl with an exponent */
    double open = 1.0 - z[0] * sign(v);
    z[0] += way / j->pre_travel * pow(open > 0.0 ? open : 0.0, j->pre_power);
    return full * z[0];
  }
  case 2: /* LuGre */
    g = 1.0 + j->pre_rise * exp(-(v / j->pre_speed) * (v / j->pre_speed));
    z[0] = (z[0] + way / j->pre_travel) / (1.0 + fabs(way) / (j->pre_travel * g));
    return full * (z[0] + 0.003 / j->pre_travel * v * (1.0 - fabs(z[0]) / g) * j->pre_travel);
  case 3: /* Iwan */
    for (i = 0; i < ELEMENTS; i++) {
      double limit = j->pre_travel * (0.3 + 0.5 * i);
      z[i] += way;
      if (fabs(z[i]) > limit) z[i] = sign(z[i]) * limit;
      sum += z[i] / limit / ELEMENTS;
    }
    return full * sum;
  default: return 0.0;
  }
}

/* Torque beside the gear, on the joint: springs, ripple, hoses, and what the catalogue does not have. */
double twin_beside(const twin_bench *b, twin_state *s, int joint, double t) {
  const twin_joint *j = &b->joint[joint];
  double q = twin_joint_angle(s->q, joint), v = twin_joint_angle(s->v, joint), x = q - j->spring_zero,
         torque = j->offset;

  switch ((int)j->spring_form) {
  case 1: torque -= j->spring_k * x; break;
  case 2: torque -= j->spring_k * x + j->spring_k3 * x * x * x; break;
  case 3: torque -= x > 0.0 ? j->spring_k * x : 0.0; break;
  case 4: torque -= x < 0.0 ? j->spring_k * x : 0.0; break;
  case 5: torque -= j->spring_k * sinh(3.0 * x) / 3.0; break;
  case 6: torque -= x > 0.0 ? j->spring_k * x * x * 3.0 : 0.0; break;
  default: break;
  }
  if (j->wander_a[0] != 0.0) torque += waves(j->wander_w, j->wander_a, j->wander_p, t + b->session_s);
  if (j->hose_torque != 0.0) { /* Bouc-Wen */
    double way = v * b->step_s / j->hose_travel, z = s->hose[joint];
    s->hose[joint] = z + way - 0.6 * fabs(way) * z - 0.4 * way * fabs(z);
    torque -= j->hose_torque * s->hose[joint];
  }
  if (j->product != 0.0) torque += j->product * v * twin_joint_angle(s->v, 1 - joint);
  return torque;
}

/* Twist of the transmission: what turns the drive, and what the joint gets. */
void twin_coupling(const twin_bench *b, const twin_state *s, int joint, double *drive_torque,
                   double *joint_torque) {
  const twin_joint *j = &b->joint[joint];
  int at = joint == KNEE ? DRIVE_K : DRIVE_A;
  double motor = s->motor[joint], error, slope = 1.0, twist, rate, side, torque;
  int i;

  error = waves(j->angle_n, j->angle_a, j->angle_p, motor);
  for (i = 0; i < MAX_WAVES; i++)
    if (j->angle_a[i] != 0.0)
      slope += j->angle_a[i] * j->angle_n[i] * s->ratio[joint] * cos(j->angle_n[i] * motor + j->angle_p[i]);
  twist = s->q[at] + error - twin_joint_angle(s->q, joint);
  rate = s->v[at] * slope - twin_joint_angle(s->v, joint);
  side = sign(twist);
  twist = fabs(twist) > j->gap_half ? twist - side * j->gap_half : 0.0;
  torque = j->stiffness * twist;
  if (j->elastic_form > 2.5) { /* soft at first */
    double soft = fabs(twist) < j->soft_zone ? fabs(twist) : j->soft_zone;
    torque -= side * j->stiffness * (1.0 - j->soft_share) * soft;
  } else if (j->elastic_form > 1.5) {
    torque += j->hardening * twist * twist * twist;
  }
  if (twist != 0.0 || j->gap_half == 0.0) torque += j->damping * j->stiffness * rate;
  if (j->gap_half > 0.0 && torque * side < 0.0) torque = 0.0; /* faces push, they do not pull */
  torque += j->gap_coulomb * tanh(rate / 0.01);
  *drive_torque = -torque * slope;
  *joint_torque = torque;
}

/* Torque of the motor in the winding, at its shaft. */
double twin_motor_torque(const twin_bench *b, const twin_state *s, int joint, double t) {
  const twin_joint *j = &b->joint[joint];
  double i = s->current[joint], x = fabs(i) / (j->sat_ref > 0.0 ? j->sat_ref : 1.0), given = i, k;

  x = fmin(x, 1.5); /* measured up to the peak; beyond it the droop does not grow for ever */
  switch ((int)j->sat_form) {
  case 1: given = i * (1.0 - j->sat_droop * x * x); break;
  case 2: given = i / (1.0 + j->sat_droop / (1.0 - j->sat_droop) * x); break;
  case 3: given = i * (1.0 - j->sat_droop * log(1.0 + x * 4.0) / log(5.0)); break;
  case 4:
    given = i * (1.0 - j->sat_droop * (x > j->sat_width ? (x - j->sat_width) / (1.0 - j->sat_width) : 0.0));
    break;
  case 5: given = i * (1.0 - j->sat_droop * x); break;
  default: break;
  }
  if (j->dead_zone > 0.0) given = fabs(given) > j->dead_zone ? given - sign(given) * j->dead_zone : 0.0;
  k = j->torque_constant * (1.0 + waves(b->bus_w, b->bus_a, b->bus_p, t + b->session_s));
  return k * given + waves(j->cog_n, j->cog_a, j->cog_p, s->motor[joint]);
}
