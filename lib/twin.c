/* twin.c: see talus/experimental/twin.h. */
#include "talus/experimental/twin.h"

#include <math.h>
#include <string.h>

#include "math_inline.h"
#include "talus/math.h"
#include "talus/random.h"

/* what random numbers are for (tl_random_*'s stream) */
#define JITTER_STREAM 0x6a697474ULL
#define CURRENT_STREAM 0x63757272ULL
#define CAMERA_STREAM 0x63616d65ULL

#define BANDWIDTH_HZ 10.0
#define DAMPING 0.8
#define HEADROOM 1.5       /* current limit over what gravity, friction and that acceleration need */
#define NOISE_SHARE 0.0025 /* of the current limit */

/* ---- drives ------------------------------------------------------------------ */

/* the plant that moves: the model, unless effects change its linkage */
static const tl_model *plant_of(const tl_twin *b) {
  return b->settings.effects ? &b->truth : b->model;
}

/* what an encoder shows at an angle */
static double reading(const tl_effect_waves *error, double angle) {
  double wave[3];

  if (error->n == 0) return angle;
  tl_effect_waves_at(error, angle, wave);
  return angle + wave[0];
}

/* the angle that the drive's encoder shows */
static double drive_reading(const tl_twin *b, int joint) {
  double position = tl_drive_position(plant_of(b), joint, b->simulation.motion.q[joint]);

  return reading(&b->change[joint].motor_encoder, position);
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
    double seen = tl_loop_grid(drive_reading(b, j), s->drive_step_rad[j]);
    double target = tl_drive_position(b->model, j, reference.q[j]);
    double target_velocity = tl_drive_ratio(b->model, j, reference.q[j]) * reference.v[j], current;
    double velocity = tl_loop_speed(seen, s->control_hz, share, &b->position[j], &b->velocity[j]);
    current = s->stiffness[j] * (target - seen) + s->damping[j] * (target_velocity - velocity);
    if (current > s->current_limit_A[j]) current = s->current_limit_A[j];
    if (current < -s->current_limit_A[j]) current = -s->current_limit_A[j];
    b->current_A[j] = current;
    b->torque[j] = current * tl_torque_per_current(b->model, j, b->simulation.motion.q[j]);
  }
}

/* ---- sensors ----------------------------------------------------------------- */

/* absolute angle of the link that a joint moves, without noise */
static double link_angle(const tl_motion *joints, int joint) {
  double angle = joints->q[0];
  int j;

  for (j = 1; j <= joint; j++) angle += joints->q[j];
  return angle;
}

static void put(double row[TL_CHANNEL_COUNT], tl_channel channel, double value) {
  if (channel != TL_NO_CHANNEL) row[channel] = value;
}

/* what a sensor of each kind shows of a joint, before it is asked whether there is one */
static void record_joint(const tl_twin *b, const tl_motion *joints, int j, double current, double camera,
                         double row[TL_CHANNEL_COUNT]) {
  const tl_sensors *has = &tl_plant_facts(b->model->plant)->sensors;
  const tl_twin_settings *s = &b->settings;
  double angle = link_angle(joints, j) + camera;
  tl_motion reference;

  angle += tl_simulation_base_angle(&b->simulation);
  put(row, has->position[j], tl_loop_grid(drive_reading(b, j), s->drive_step_rad[j]));
  put(row, has->encoder[j],
      tl_loop_grid(reading(&b->change[j].joint_encoder, joints->q[j]), s->ankle_step_rad));
  put(row, has->camera[j], angle);
  put(row, has->current[j], current);
  put(row, has->torque[j], current * tl_torque_per_current(b->model, j, b->simulation.motion.q[j]));
  if (has->command[j] == TL_NO_CHANNEL) return;
  reference_at(b, b->simulation.t_s, &reference);
  row[has->command[j]] = reference.q[j];
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
    now.motor_Nm = tl_motor_torque(b->model, b->torque[joint], now.ratio);
    tl_effect_law(&s->effect[i], &now, &torque, &friction);
    sum += torque / tl_torque_ratio(b->model, joint, now.q);
  }
  return sum != 0.0 ? sum / tl_torque_per_current(b->model, joint, motion->q[joint]) : 0.0;
}

/* every sensor of the plant at an instant of the recording; shown: the currents without noise */
static void record(const tl_twin *b, double t_s, const double *shown, double row[TL_CHANNEL_COUNT]) {
  const tl_twin_settings *s = &b->settings;
  double current[2], camera[2];
  tl_motion joints;
  int j;

  tl_random_normal2(s->seed, CURRENT_STREAM, b->sample, current);
  tl_random_normal2(s->seed, CAMERA_STREAM, b->sample, camera);
  tl_simulation_joints(b->model, &b->simulation, &joints);
  row[TL_CHANNEL_TIME] = t_s;
  for (j = 0; j < TL_MAX_JOINTS && j < tl_joint_count(b->model); j++)
    record_joint(b, &joints, j, shown[j] + s->current_noise_A[j] * current[j],
                 s->camera_noise_rad * camera[j], row);
}

static uint32_t bit_of(tl_channel channel) {
  return channel == TL_NO_CHANNEL ? 0 : TL_CHANNEL_BIT(channel);
}

static uint32_t recordable(const tl_model *m) {
  const tl_sensors *s = &tl_plant_facts(m->plant)->sensors;
  uint32_t set = TL_CHANNEL_BIT(TL_CHANNEL_TIME);
  int j;

  for (j = 0; j < tl_joint_count(m); j++)
    set |= bit_of(s->position[j]) | bit_of(s->encoder[j]) | bit_of(s->camera[j]) | bit_of(s->current[j]) |
           bit_of(s->torque[j]) | bit_of(s->command[j]);
  return set;
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
  if (base.mount_modes > TL_MOUNT_MODES || !tl_simulation_mount_rings(b->model, base.mount, base.mount_modes))
    return TL_ERR_RANGE;
  b->truth = *b->model;
  for (j = 0; j < tl_joint_count(b->model) && status == TL_OK; j++) {
    b->change[j] = tl_effects_change(s->effect, s->effects, j);
    if (b->change[j].motor_encoder.n > TL_EFFECT_WAVES || b->change[j].joint_encoder.n > TL_EFFECT_WAVES ||
        b->change[j].ripple.n > TL_EFFECT_WAVES)
      return TL_ERR_RANGE;
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
    made.position[j] = tl_loop_grid(drive_reading(&made, j), s->drive_step_rad[j]);
  *b = made;
  return TL_OK;
}

void tl_twin_reference(const tl_twin *b, tl_motion *reference) {
  reference_at(b, b->simulation.t_s, reference);
}

/* ---- defaults ------------------------------------------------------------------ */

/* gains that give the wanted bandwidth to the inertia at rest, and a limit that holds it up
 * horizontally, overcomes friction and accelerates */
static void choose_drives(const tl_model *m, tl_twin_settings *s) {
  double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS], w = 2.0 * TL_PI * BANDWIDTH_HZ, torque[TL_MAX_JOINTS];
  tl_motion worst;
  int joints = tl_joint_count(m), j;

  memset(&worst, 0, sizeof worst);
  worst.q[0] = 0.5 * TL_PI + tl_gravity_zero(m);
  for (j = 0; j < joints; j++) {
    worst.a[j] = tl_plant_facts(m->plant)->bench.acceleration;
    worst.slip[j] = 1.0;
  }
  tl_inverse(m, &worst, torque);
  memset(&worst, 0, sizeof worst);
  tl_inertia_matrix(m, worst.q, matrix);
  for (j = 0; j < joints; j++) {
    double per_current = fabs(tl_torque_per_current(m, j, worst.q[j]));
    double ratio = tl_drive_ratio(m, j, worst.q[j]);
    double inertia = matrix[tl_entry(joints, j, j)] / (ratio * ratio); /* that the drive sees */
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
  const tl_facts *f = tl_plant_facts(m->plant);
  int j;

  s.settle_s = settling(e);
  s.ankle_step_rad = 2.0 * TL_PI / 65536.0;
  choose_drives(m, &s);
  s.channels = f->channels.required;
  for (j = 0; j < tl_joint_count(m); j++) {
    s.drive_step_rad[j] = f->bench.drive_step[j];
    s.current_noise_A[j] = f->bench.current_noise_A[j];
    if (s.current_noise_A[j] == 0.0) s.current_noise_A[j] = NOISE_SHARE * s.current_limit_A[j];
    s.channels |= bit_of(f->sensors.position[j]) | bit_of(f->sensors.current[j]);
  }
  return s;
}

void tl_twin_limits(const tl_model *m, const tl_twin_settings *s, tl_limits limits[TL_MAX_JOINTS]) {
  const tl_plant_bench *bench = &tl_plant_facts(m->plant)->bench;
  int j;

  for (j = 0; j < TL_MAX_JOINTS; j++) {
    limits[j] = tl_limits_none();
    if (j >= tl_joint_count(m)) continue;
    limits[j].speed = bench->speed;
    limits[j].acceleration = bench->acceleration;
    limits[j].torque = s->current_limit_A[j] * fabs(tl_torque_per_current(m, j, 0.0));
    if (bench->position[j] == 0.0) continue;
    limits[j].position_high = bench->position[j];
    limits[j].position_low = -bench->position[j];
  }
}
