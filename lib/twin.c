/* twin.c: see talus/experimental/twin.h. */
#include "talus/experimental/twin.h"

#include <math.h>
#include <string.h>

#include "effect_link.h"
#include "simulate_effects.h"
#include "talus/math.h"
#include "talus/random.h"
#include "transmission_internal.h"

/* what random numbers are for (tl_random_*'s stream) */
#define JITTER_STREAM 0x6a697474ULL
#define CURRENT_STREAM 0x63757272ULL
#define CAMERA_STREAM 0x63616d65ULL

#define BANDWIDTH_HZ 10.0
#define DAMPING 0.8
#define ROTARY_SPEED 8.0          /* [rad/s] */
#define ROTARY_ACCELERATION 100.0 /* [rad/s^2] */
#define SLIDER_SPEED 2.0          /* [m/s] */
#define SLIDER_ACCELERATION 20.0  /* [m/s^2] */
#define HEADROOM 1.5              /* current limit over what gravity, friction and that acceleration need */
#define NOISE_SHARE 0.0025        /* of the current limit */

/* ---- drives ------------------------------------------------------------------ */

/* torque as tl_forward takes it, for a current of 1 A (a slider's drive is in newtons) */
static double torque_per_current(const tl_model *m, int joint, const double *q) {
  const tl_drive *d = &m->drive[joint];
  double ratio, slope;

  if (m->plant == TL_PLANT_SLIDER) return 1.0;
  if (m->plant == TL_PLANT_LEG) return d->torque_constant_Nm_A;
  tl_transmission_ratio(&d->transmission, q[joint], &ratio, &slope);
  return ratio * d->torque_constant_Nm_A;
}

/* how far what the drive sees moves for a unit of joint motion */
static double drive_ratio(const tl_model *m, int joint, const double *q) {
  double ratio = 1.0, slope;

  if (m->plant == TL_PLANT_LEG)
    tl_transmission_ratio(&m->drive[joint].transmission, q[joint], &ratio, &slope);
  return ratio;
}

static double drive_position(const tl_model *m, int joint, const double *q) {
  if (m->plant != TL_PLANT_LEG) return q[joint];
  return tl_transmission_motor_angle(&m->drive[joint].transmission, q[joint]);
}

static double rounded(double x, double step) {
  return step > 0.0 ? floor(x / step + 0.5) * step : x;
}

/* the plant that moves: the model, unless effects change its linkage */
static const tl_model *plant_of(const tl_twin *b) {
  return b->settings.effects ? &b->truth : b->model;
}

/* the angle that the drive's encoder shows */
static double drive_reading(const tl_twin *b, int joint) {
  const tl_effect_change *c = &b->change[joint];
  double position = drive_position(plant_of(b), joint, b->simulation.motion.q), sine, cosine;

  if (c->motor_sine_rad == 0.0 && c->motor_cosine_rad == 0.0) return position;
  tl_sincos(position, &sine, &cosine);
  return position + c->motor_sine_rad * sine + c->motor_cosine_rad * cosine;
}

/* where the excitation stands: a series runs while the bench settles, ramps wait */
static void reference_at(const tl_twin *b, double t, tl_motion *reference) {
  double begin = b->excitation->kind == TL_EXCITATION_RAMPS ? b->settings.settle_s : 0.0;

  tl_excitation_at(b->excitation, t - begin, reference);
}

/* one tick of the position control: PD on position and low-passed velocity, the current limited and
 * then held */
static void control(tl_twin *b, double t) {
  const tl_twin_settings *s = &b->settings;
  double share = 1.0 - tl_exp(-2.0 * TL_PI * s->velocity_hz / s->control_hz);
  tl_motion reference;
  int j;

  reference_at(b, t, &reference);
  for (j = 0; j < tl_joint_count(b->model); j++) {
    double seen = rounded(drive_reading(b, j), s->drive_step_rad[j]);
    double target = drive_position(b->model, j, reference.q);
    double target_velocity = drive_ratio(b->model, j, reference.q) * reference.v[j], current;
    b->velocity[j] += share * ((seen - b->position[j]) * s->control_hz - b->velocity[j]);
    b->position[j] = seen;
    current = s->stiffness[j] * (target - seen) + s->damping[j] * (target_velocity - b->velocity[j]);
    if (current > s->current_limit_A[j]) current = s->current_limit_A[j];
    if (current < -s->current_limit_A[j]) current = -s->current_limit_A[j];
    b->current_A[j] = current;
    b->torque[j] = current * torque_per_current(b->model, j, b->simulation.motion.q);
  }
}

/* ---- sensors ----------------------------------------------------------------- */

/* what the ankle's encoder shows at an angle */
static double joint_reading(const tl_effect_change *c, double q) {
  double sine, cosine;

  if (c->joint_sine_rad == 0.0 && c->joint_cosine_rad == 0.0) return q;
  tl_sincos(q, &sine, &cosine);
  return q + c->joint_sine_rad * sine + c->joint_cosine_rad * cosine;
}

static void record_leg(const tl_twin *b, const double *current, const double *camera,
                       double row[TL_CHANNEL_COUNT]) {
  const tl_twin_settings *s = &b->settings;
  tl_motion joints;
  const double *q = joints.q;

  tl_simulation_joints(&b->simulation, &joints);
  row[TL_CHANNEL_KNEE_MOTOR] = rounded(drive_reading(b, 0), s->drive_step_rad[0]);
  row[TL_CHANNEL_ANKLE_MOTOR] = rounded(drive_reading(b, 1), s->drive_step_rad[1]);
  row[TL_CHANNEL_ANKLE_JOINT] = rounded(joint_reading(&b->change[1], q[1]), s->ankle_step_rad);
  row[TL_CHANNEL_KNEE_CURRENT] = current[0];
  row[TL_CHANNEL_ANKLE_CURRENT] = current[1];
  row[TL_CHANNEL_SHANK] = q[0] + camera[0];
  row[TL_CHANNEL_FOOT] = q[0] + q[1] + camera[1];
  if (!b->simulation.beyond.begun) return;
  row[TL_CHANNEL_SHANK] += b->simulation.beyond.q[TL_MAX_JOINTS];
  row[TL_CHANNEL_FOOT] += b->simulation.beyond.q[TL_MAX_JOINTS];
}

/* What the drive's current shows beside the torque that it makes, over the torque of 1 A: the effects
 * that act on measurements. They see the torque that really acts. */
static double current_beside(const tl_twin *b, int joint) {
  const tl_twin_settings *s = &b->settings;
  const tl_motion *motion = &b->simulation.motion;
  double sum = 0.0, torque, friction;
  tl_effect_instant now;
  int i;

  for (i = 0; i < s->effects; i++) {
    if (s->effect[i].kind->acts != TL_EFFECT_MEASURED || !tl_effect_at(&s->effect[i], joint)) continue;
    tl_effect_instant_of(b->model, motion, joint, b->simulation.t_s - s->settle_s, NULL, &now);
    now.motor_Nm = b->torque[joint] / (b->model->plant == TL_PLANT_LEG ? 1.0 : now.ratio);
    tl_effect_law(&s->effect[i], &now, &torque, &friction);
    sum += torque / (b->model->plant == TL_PLANT_LEG ? now.ratio : 1.0);
  }
  return sum != 0.0 ? sum / torque_per_current(b->model, joint, motion->q) : 0.0;
}

/* every sensor of the plant at an instant of the recording; shown: the currents without noise */
static void record(const tl_twin *b, double t_s, const double *shown, double row[TL_CHANNEL_COUNT]) {
  const tl_twin_settings *s = &b->settings;
  const double *q = b->simulation.motion.q;
  double current[2], camera[2];
  tl_motion reference;
  int j;

  tl_random_normal2(s->seed, CURRENT_STREAM, b->sample, current);
  tl_random_normal2(s->seed, CAMERA_STREAM, b->sample, camera);
  for (j = 0; j < TL_MAX_JOINTS; j++) {
    current[j] = shown[j] + s->current_noise_A[j] * current[j];
    camera[j] *= s->camera_noise_rad;
  }
  row[TL_CHANNEL_TIME] = t_s;
  if (b->model->plant == TL_PLANT_LEG) {
    record_leg(b, current, camera, row);
  } else if (b->model->plant == TL_PLANT_PENDULUM) {
    row[TL_CHANNEL_JOINT] = rounded(q[0], s->drive_step_rad[0]);
    row[TL_CHANNEL_JOINT_CURRENT] = current[0];
    row[TL_CHANNEL_JOINT_TORQUE] = current[0] * torque_per_current(b->model, 0, q);
  } else {
    reference_at(b, b->simulation.t_s, &reference);
    row[TL_CHANNEL_SLIDER] = rounded(q[0], s->drive_step_rad[0]);
    row[TL_CHANNEL_SLIDER_FORCE] = current[0];
    row[TL_CHANNEL_SLIDER_COMMAND] = reference.q[0];
  }
}

static uint32_t recordable(const tl_model *m) {
  uint32_t time = TL_CHANNEL_BIT(TL_CHANNEL_TIME);

  if (m->plant == TL_PLANT_LEG)
    return time | TL_CHANNEL_BIT(TL_CHANNEL_KNEE_MOTOR) | TL_CHANNEL_BIT(TL_CHANNEL_ANKLE_MOTOR) |
           TL_CHANNEL_BIT(TL_CHANNEL_ANKLE_JOINT) | TL_CHANNEL_BIT(TL_CHANNEL_KNEE_CURRENT) |
           TL_CHANNEL_BIT(TL_CHANNEL_ANKLE_CURRENT) | TL_CHANNEL_BIT(TL_CHANNEL_SHANK) |
           TL_CHANNEL_BIT(TL_CHANNEL_FOOT);
  if (m->plant == TL_PLANT_PENDULUM)
    return time | TL_CHANNEL_BIT(TL_CHANNEL_JOINT) | TL_CHANNEL_BIT(TL_CHANNEL_JOINT_CURRENT) |
           TL_CHANNEL_BIT(TL_CHANNEL_JOINT_TORQUE);
  return time | TL_CHANNEL_BIT(TL_CHANNEL_SLIDER) | TL_CHANNEL_BIT(TL_CHANNEL_SLIDER_FORCE) |
         TL_CHANNEL_BIT(TL_CHANNEL_SLIDER_COMMAND);
}

/* ---- in time ----------------------------------------------------------------- */

/* Instant of sample k on the recording's clock. Samples lie amid two ticks, as far as their rates
 * allow, so that a held current is seen neither early nor late on average. */
static double sample_time(const tl_twin_settings *s, uint64_t k) {
  double first = (floor(s->jitter_s * s->control_hz + 0.5) + 0.5) / s->control_hz, draw[2], t, per_s;

  tl_random_uniform2(s->seed, JITTER_STREAM, k, draw);
  t = (double)k / s->sample_hz + first + (2.0 * draw[0] - 1.0) * s->jitter_s;
  if (!(s->clock_s > 0.0)) return t;
  per_s = 1.0 / s->clock_s; /* a whole number over it is the double nearest to its decimal text */
  return floor(t * per_s + 0.5) / per_s;
}

static tl_status run_to(tl_twin *b, double t) {
  return tl_simulate(plant_of(b), tl_held_torque, b->torque, b->settings.step_s, &b->simulation, t);
}

/* currents that the drives show now */
static double shown_now(const tl_twin *b, int joint) {
  return b->current_A[joint] + (b->settings.effects ? current_beside(b, joint) : 0.0);
}

/* all ticks of the control up to an instant, and the plant to there */
static tl_status run_ticks(tl_twin *b, double until) {
  tl_status status = TL_OK;
  double tick;
  int j;

  while (status == TL_OK && (tick = (double)b->tick / b->settings.control_hz) <= until) {
    status = run_to(b, tick);
    if (status != TL_OK) break;
    control(b, tick);
    for (j = 0; j < tl_joint_count(b->model) && b->settings.effects; j++)
      b->shown_A[j][b->tick % TL_TWIN_TICKS] = shown_now(b, j);
    b->tick++;
  }
  return status == TL_OK ? run_to(b, until) : status;
}

/* a current sampled at another instant: from the last ticks, or from a bench that runs ahead */
static tl_status shown_later(const tl_twin *b, int joint, double delay_s, double *shown) {
  double tick = floor((b->simulation.t_s - delay_s) * b->settings.control_hz + 1e-9);
  tl_twin ahead;
  tl_status status;

  if (delay_s >= 0.0) {
    *shown = tick >= 0.0 ? b->shown_A[joint][(uint64_t)tick % TL_TWIN_TICKS] : 0.0;
    return TL_OK;
  }
  ahead = *b;
  status = run_ticks(&ahead, b->simulation.t_s - delay_s);
  *shown = shown_now(&ahead, joint);
  return status;
}

tl_status tl_twin_next(tl_twin *b, double row[TL_CHANNEL_COUNT]) {
  double t_s = sample_time(&b->settings, b->sample), until = b->settings.settle_s + t_s;
  double measured[TL_CHANNEL_COUNT] = {0.0}, shown[TL_MAX_JOINTS] = {0.0, 0.0};
  tl_status status = run_ticks(b, until);
  int channel, j;

  for (j = 0; j < tl_joint_count(b->model) && status == TL_OK; j++) {
    shown[j] = shown_now(b, j);
    if (b->change[j].delay_s != 0.0) status = shown_later(b, j, b->change[j].delay_s, &shown[j]);
  }
  if (status != TL_OK) return status;
  record(b, t_s, shown, measured);
  for (channel = 0; channel < TL_CHANNEL_COUNT; channel++)
    row[channel] = b->settings.channels & TL_CHANNEL_BIT(channel) ? measured[channel] : (double)NAN;
  b->sample++;
  return TL_OK;
}

static int is_between(double x, double low, double high) {
  return x >= low && x <= high;
}

static int in_range(const tl_twin_settings *s) {
  const double most = 1e12;
  int j;

  for (j = 0; j < TL_MAX_JOINTS; j++) {
    if (!is_between(s->stiffness[j], 0.0, most) || !is_between(s->damping[j], 0.0, most)) return 0;
    if (!is_between(s->current_limit_A[j], 0.0, most) || !is_between(s->drive_step_rad[j], 0.0, 1.0))
      return 0;
    if (!is_between(s->current_noise_A[j], 0.0, most)) return 0;
  }
  if (!is_between(s->control_hz, 1.0, 1e6) || !is_between(s->velocity_hz, 1e-3, 1e6)) return 0;
  if (!is_between(s->ankle_step_rad, 0.0, 1.0) || !is_between(s->camera_noise_rad, 0.0, 1.0)) return 0;
  if (!is_between(s->sample_hz, 1e-3, s->control_hz) || !is_between(s->jitter_s, 0.0, 0.45 / s->sample_hz))
    return 0;
  if (!is_between(s->clock_s, 0.0, 0.04 / s->sample_hz) || !is_between(s->settle_s, 0.0, 1e6)) return 0;
  return is_between(s->step_s, 1e-6, 1.0);
}

/* can these effects act on this bench? */
static tl_status check_effects(const tl_model *m, const tl_twin_settings *s) {
  tl_status status = tl_effects_check(s->effect, s->effects, m);
  int i;

  if (status != TL_OK) return status;
  for (i = 0; i < s->effects; i++) {
    if (s->effect[i].kind->needs_load_sensor || tl_effect_fit_only(&s->effect[i]) >= 0 ||
        m->form == TL_FORM_PAPER)
      return TL_ERR_UNSUPPORTED;
  }
  return TL_OK;
}

/* the plant as effects leave it */
static tl_status make_truth(tl_twin *b) {
  const tl_twin_settings *s = &b->settings;
  tl_status status = TL_OK;
  tl_effect_change base;
  int j;

  base = tl_effects_change(s->effect, s->effects, TL_MAX_JOINTS);
  if (base.base_compliance_rad_Nm > 0.0 && !(tl_effect_dynamics_base_inertia(b->model, &base) > 0.0))
    return TL_ERR_RANGE;
  b->truth = *b->model;
  for (j = 0; j < tl_joint_count(b->model) && status == TL_OK; j++) {
    b->change[j] = tl_effects_change(s->effect, s->effects, j);
    if (fabs(b->change[j].delay_s) * s->control_hz > TL_TWIN_TICKS - 2) return TL_ERR_RANGE;
    status = tl_effect_change_linkage(&b->change[j], &b->model->drive[j].transmission,
                                      &b->truth.drive[j].transmission);
  }
  return status;
}

tl_status tl_twin_init(tl_twin *b, const tl_model *m, const tl_excitation *e, const tl_twin_settings *s) {
  tl_twin made;
  tl_motion start;
  tl_status status;
  int j;

  if (!b || !m || !e || !s || e->joints != tl_joint_count(m)) return TL_ERR_ARGUMENT;
  if (!in_range(s)) return TL_ERR_RANGE;
  if (s->channels & ~recordable(m)) return TL_ERR_UNSUPPORTED;
  status = check_effects(m, s);
  if (status != TL_OK) return status;
  memset(&made, 0, sizeof made);
  made.model = m;
  made.excitation = e;
  made.settings = *s;
  /* whole control periods, or samples would not lie amid two ticks and see the held current early */
  made.settings.settle_s = floor(s->settle_s * s->control_hz + 0.5) / s->control_hz;
  if (s->effects) status = make_truth(&made);
  if (status != TL_OK) return status;
  reference_at(&made, 0.0, &start);
  memset(start.v, 0, sizeof start.v);
  status = tl_simulation_init(&made.simulation, m, start.q, start.v);
  if (status != TL_OK) return status;
  made.simulation.effect = s->effect;
  made.simulation.effects = s->effects;
  made.simulation.effects_begin_s = s->settle_s;
  for (j = 0; j < tl_joint_count(m); j++)
    made.position[j] = rounded(drive_reading(&made, j), s->drive_step_rad[j]);
  *b = made;
  return TL_OK;
}

void tl_twin_reference(const tl_twin *b, tl_motion *reference) {
  reference_at(b, b->simulation.t_s, reference);
}

/* ---- defaults ------------------------------------------------------------------ */

static double acceleration_of(const tl_model *m) {
  return m->plant == TL_PLANT_SLIDER ? SLIDER_ACCELERATION : ROTARY_ACCELERATION;
}

/* gains that give the wanted bandwidth to the inertia at rest, and a limit that holds it up
 * horizontally, overcomes friction and accelerates */
static void choose_drives(const tl_model *m, tl_twin_settings *s) {
  double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS], w = 2.0 * TL_PI * BANDWIDTH_HZ, torque[TL_MAX_JOINTS];
  tl_motion worst;
  int joints = tl_joint_count(m), j;

  memset(&worst, 0, sizeof worst);
  worst.q[0] = 0.5 * TL_PI + (m->plant == TL_PLANT_PENDULUM ? m->gravity_zero_rad : 0.0);
  for (j = 0; j < joints; j++) {
    worst.a[j] = acceleration_of(m);
    worst.slip[j] = 1.0;
  }
  tl_inverse(m, &worst, torque);
  memset(&worst, 0, sizeof worst);
  tl_inertia_matrix(m, worst.q, matrix);
  for (j = 0; j < joints; j++) {
    double per_current = fabs(torque_per_current(m, j, worst.q)), ratio = drive_ratio(m, j, worst.q);
    double inertia = matrix[j * joints + j] / (ratio * ratio); /* that the drive sees */
    s->stiffness[j] = inertia * w * w / per_current;
    s->damping[j] = inertia * 2.0 * DAMPING * w / per_current;
    s->current_limit_A[j] = HEADROOM * fabs(torque[j]) / per_current;
  }
}

static double settling(const tl_excitation *e) {
  double period = tl_excitation_length_s(e);

  if (e->kind == TL_EXCITATION_RAMPS) return 1.0;
  return period * -floor(-(e->fade_s + 1.0) / period);
}

tl_twin_settings tl_twin_defaults(const tl_model *m, const tl_excitation *e) {
  tl_twin_settings s = {.control_hz = 1000.0,
                        .velocity_hz = 100.0,
                        .sample_hz = 250.0,
                        .jitter_s = 3e-4,
                        .clock_s = 1e-6,
                        .step_s = 1e-3,
                        .camera_noise_rad = 1e-3,
                        .seed = 1};
  tl_channel_set set;
  int j;

  s.settle_s = settling(e);
  s.ankle_step_rad = 2.0 * TL_PI / 65536.0;
  choose_drives(m, &s);
  for (j = 0; j < tl_joint_count(m); j++) {
    s.drive_step_rad[j] = 2.0 * TL_PI / (m->plant == TL_PLANT_LEG ? 16384.0 : 262144.0);
    s.current_noise_A[j] = NOISE_SHARE * s.current_limit_A[j];
  }
  if (m->plant == TL_PLANT_SLIDER) s.drive_step_rad[0] = 1e-6;
  if (m->plant == TL_PLANT_LEG) {
    s.current_noise_A[0] = 0.020;
    s.current_noise_A[1] = 0.005;
  }
  if (tl_channel_set_of(m->plant, &set) == TL_OK) s.channels = set.required;
  if (m->plant == TL_PLANT_PENDULUM)
    s.channels |= TL_CHANNEL_BIT(TL_CHANNEL_JOINT) | TL_CHANNEL_BIT(TL_CHANNEL_JOINT_CURRENT);
  return s;
}

void tl_twin_limits(const tl_model *m, const tl_twin_settings *s, tl_limits limits[TL_MAX_JOINTS]) {
  const double rest[TL_MAX_JOINTS] = {0.0, 0.0};
  int j;

  for (j = 0; j < TL_MAX_JOINTS; j++) {
    limits[j] = tl_limits_none();
    if (j >= tl_joint_count(m)) continue;
    limits[j].speed = m->plant == TL_PLANT_SLIDER ? SLIDER_SPEED : ROTARY_SPEED;
    limits[j].acceleration = acceleration_of(m);
    limits[j].torque = s->current_limit_A[j] * fabs(torque_per_current(m, j, rest));
    if (m->plant != TL_PLANT_LEG) continue;
    limits[j].position_high = j == 0 ? 1.0 : 0.5;
    limits[j].position_low = -limits[j].position_high;
  }
}
