/* same_bits.c: one hash over what the library computes from fixed inputs: identification, prediction, simulation, tables, controller.
 *
 * tools/check-arch compiles it with the library's sources for every machine and compares. It needs the library alone. Zeros
 * of either sign count, NaN counts as one word whatever its bits: no standard says them.
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "talus/experimental.h"
#include "talus/talus.h"

#define ROWS 2000
#define STATES 20000
#define WORK 200000

static uint64_t hash;
static tl_model leg;
static tl_effect effects[3];

static void begin(void) {
  hash = 14695981039346656037ULL;
}

/* FNV-1a over the bytes of a word, lowest first */
static void fold(uint64_t word) {
  int i;

  for (i = 0; i < 8; i++) hash = (hash ^ (word >> (8 * i) & 255U)) * 1099511628211ULL;
}

static void fold_double(double x) {
  uint64_t bits;

  memcpy(&bits, &x, sizeof bits);
  fold(x != x ? 0x7ff8000000000000ULL : bits);
}

static void fold_doubles(const double *x, size_t n) {
  size_t i;

  for (i = 0; i < n; i++) fold_double(x[i]);
}

static double draw(uint64_t stream, uint64_t i, double low, double high) {
  double u[2];

  tl_random_uniform2(7, stream, i, u);
  return low + (high - low) * u[0];
}

static tl_status make_leg(void) {
  static const tl_screw_linkage link = {0.002, 0.090, 0.040, 0.035, 84.75};
  tl_status status = tl_model_init(&leg, TL_PLANT_LEG);

  leg.shank_length_m = 0.3615;
  leg.shank_mass_kg = 1.624;
  leg.shank_com_m = 0.160;
  leg.shank_inertia_kg_m2 = 0.0420;
  leg.foot_mass_kg = 0.442;
  leg.foot_com_m = 0.055;
  leg.foot_inertia_kg_m2 = 0.0021;
  leg.ankle_motor_mass_kg = 0.4112;
  leg.ankle_motor_com_m = 0.120;
  leg.drive[0].torque_constant_Nm_A = leg.drive[1].torque_constant_Nm_A = 0.1031;
  leg.drive[1].rotor_inertia_kg_m2 = 2.4e-6;
  leg.drive[0].coulomb_Nm = 1.2;
  leg.drive[0].viscous_Nms_rad = 0.45;
  leg.drive[1].coulomb_Nm = 0.8;
  leg.drive[1].viscous_Nms_rad = 0.30;
  if (status == TL_OK) status = tl_transmission_fixed(&leg.drive[0].transmission, 51.0);
  if (status == TL_OK) status = tl_transmission_screw_linkage(&leg.drive[1].transmission, &link);
  effects[0] = tl_effect_typical(tl_effect_find("stribeck"), 1);
  effects[1] = tl_effect_typical(tl_effect_find("load_friction"), 0);
  effects[2] = tl_effect_typical(tl_effect_find("gravity_tilt"), TL_MAX_JOINTS);
  return status;
}

/* ---- identification and prediction --------------------------------------------------- */

static double q[2 * ROWS], v[2 * ROWS], a[2 * ROWS], torque[2 * ROWS], work[WORK];

static void make_motion(void) {
  size_t i;
  int j;

  for (j = 0; j < 2; j++)
    for (i = 0; i < ROWS; i++) {
      size_t at = (size_t)j * ROWS + i;
      double sine, cosine, omega = 5.0 + 3.0 * j, amplitude = j ? 0.3 : 0.6;

      tl_sincos(omega * (double)i * 0.005, &sine, &cosine);
      q[at] = amplitude * sine;
      v[at] = amplitude * omega * cosine;
      a[at] = -amplitude * omega * omega * sine + draw(3, at, -3.0, 3.0);
    }
}

static tl_status predict(void) {
  begin();
  tl_inverse_batch(&leg, ROWS, q, v, a, NULL, torque);
  fold_doubles(torque, sizeof torque / sizeof *torque);
  return TL_OK;
}

static tl_status identify(void) {
  tl_identify_settings settings = tl_identify_defaults();
  static tl_problem problem;
  static tl_identify_result result;
  tl_factor factor[2];
  double best[TL_MAX_PARAMETERS];
  int index[TL_MAX_ROW], j;
  uint64_t evaluations;
  tl_status status = TL_OK;
  size_t i;

  begin();
  for (i = 0; i < 2 * ROWS; i++) torque[i] += draw(4, i, -0.01, 0.01);
  for (j = 0; j < 2 && status == TL_OK; j++)
    status = tl_factor_init(&factor[j], tl_row_index(&leg, j, index));
  if (status == TL_OK) status = tl_regressor_fold(&leg, ROWS, q, v, a, NULL, torque, factor);
  settings.swarm.particles = 40;
  settings.swarm.iterations = 200;
  if (status == TL_OK) status = tl_problem_init(&problem, &leg, &settings, factor);
  if (status == TL_OK && tl_identify_memory(&problem) > WORK) status = TL_ERR_WORKSPACE;
  if (status == TL_OK) status = tl_identify_swarm(&problem, work, WORK, best, &evaluations);
  if (status == TL_OK) status = tl_identify_conclude(&problem, best, &result);
  if (status != TL_OK) return status;
  fold(evaluations);
  fold_doubles(result.value, TL_MAX_PARAMETERS);
  fold_doubles(result.base, TL_MAX_BASE);
  fold_double(result.cost);
  fold_double(result.least_squares_cost);
  fold_double(result.condition_number);
  return TL_OK;
}

/* ---- simulation ------------------------------------------------------------------------ */

static tl_status simulate(void) {
  static const double q0[2] = {0.4, -0.1}, v0[2] = {0.0, 0.0};
  tl_simulation s;
  tl_status status = tl_simulation_init(&s, &leg, q0, v0);
  int i;

  begin();
  s.effect = effects;
  s.effects = 3;
  for (i = 0; i < 100 && status == TL_OK; i++) {
    double held[2] = {draw(5, (uint64_t)i, -0.1, 0.1), draw(6, (uint64_t)i, -0.02, 0.02)};

    status = tl_simulate(&leg, tl_held_torque, held, 0.001, &s, s.t_s + 0.01);
    fold_doubles(s.motion.q, 2);
    fold_doubles(s.motion.v, 2);
    fold_double(s.dissipated_J);
  }
  return status;
}

/* ---- tables and controller -------------------------------------------------------------- */

static tl_controller_f64 f64;
static tl_controller_f32 f32;
static tl_controller_q31 q31;
static tl_curve_knot_f64 knot_f64[TL_CONTROLLER_KNOTS];
static tl_curve_knot_f32 knot_f32[TL_CONTROLLER_KNOTS];
static tl_curve_knot_q31 knot_q31[TL_CONTROLLER_KNOTS];

static tl_status tables(void) {
  tl_controller_settings settings;
  int refused, i, n;
  tl_status status;

  begin();
  tl_controller_defaults(&leg, &settings);
  status = tl_controller_prepare(&f64, &leg, effects, 3, &settings, knot_f64, &refused);
  if (status != TL_OK) return status;
  tl_controller_to_f32(&f64, knot_f32, &f32);
  status = tl_controller_to_q31(&f64, knot_q31, &q31);
  n = tl_controller_knots(&f64);
  for (i = 0; i < n; i++) {
    fold_double(knot_f64[i].value);
    fold_double(knot_f64[i].rise);
    fold_double((double)knot_f32[i].value);
    fold((uint64_t)(uint32_t)knot_q31[i].value << 32 | (uint32_t)knot_q31[i].rise);
  }
  return status;
}

static void one_state(uint64_t i) {
  tl_controller_input_f64 d = {.enable = 1};
  tl_controller_input_f32 f = {.enable = 1};
  tl_controller_input_q31 w = {.enable = 1};
  static tl_controller_state_f64 state_f64;
  static tl_controller_state_f32 state_f32;
  static tl_controller_state_q31 state_q31;
  tl_controller_output_f64 out_f64;
  tl_controller_output_f32 out_f32;
  tl_controller_output_q31 out_q31;
  uint32_t saturated = 0;
  int j;

  if (!i) {
    tl_controller_start_f64(&state_f64);
    tl_controller_start_f32(&state_f32);
    tl_controller_start_q31(&state_q31);
  }
  for (j = 0; j < 2; j++) {
    double x = draw(10 + (uint64_t)j, i / 200, -0.5, 0.5), y = draw(12 + (uint64_t)j, i, -0.05, 0.05);
    double z = draw(14 + (uint64_t)j, i, -150.0, 150.0);

    w.desired.angle_rad[j] = w.measured.angle_rad[j] = tl_fixed_from_double(x, TL_Q_ANGLE, &saturated);
    w.desired.speed_rad_s[j] = w.measured.speed_rad_s[j] = tl_fixed_from_double(y, TL_Q_SPEED, &saturated);
    w.desired.acceleration[j] = tl_fixed_from_double(z, TL_Q_ACCELERATION, &saturated);
    f.desired.angle_rad[j] = f.measured.angle_rad[j] = (float)x;
    f.desired.speed_rad_s[j] = f.measured.speed_rad_s[j] = (float)y;
    f.desired.acceleration[j] = (float)z;
    d.desired.angle_rad[j] = d.measured.angle_rad[j] = x;
    d.desired.speed_rad_s[j] = d.measured.speed_rad_s[j] = y;
    d.desired.acceleration[j] = z;
  }
  w.desired.count = w.measured.count = f.desired.count = f.measured.count = (uint32_t)i;
  d.desired.count = d.measured.count = (uint32_t)i;
  tl_controller_tick_f64(&f64, &state_f64, &d, &out_f64);
  tl_controller_tick_f32(&f32, &state_f32, &f, &out_f32);
  tl_controller_tick_q31(&q31, &state_q31, &w, &out_q31);
  fold((uint64_t)out_f64.status << 32 | out_q31.status);
  for (j = 0; j < 2; j++) {
    fold_double(out_f64.current_A[j]);
    fold_double((double)out_f32.current_A[j]);
    fold((uint32_t)out_q31.current_A[j]);
  }
}

static tl_status control(void) {
  uint64_t i;

  begin();
  for (i = 0; i < STATES; i++) one_state(i);
  return TL_OK;
}

int main(void) {
  static tl_status (*const part[])(void) = {predict, identify, simulate, tables, control};
  static const char *const name[] = {"prediction", "identification", "simulation", "tables", "controller"};
  uint64_t all = 0;
  int i;

  if (make_leg() != TL_OK) return 1;
  make_motion();
  for (i = 0; i < 5; i++) {
    tl_status status = part[i]();
    if (status != TL_OK) {
      printf("%s failed: %s\n", name[i], tl_status_text(status));
      return 1;
    }
    printf("%s %016" PRIx64 "\n", name[i], hash);
    all = (all ^ hash) * 1099511628211ULL;
  }
  printf("all %016" PRIx64 "\n", all);
  return 0;
}
