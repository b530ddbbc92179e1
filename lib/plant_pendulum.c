/* plant_pendulum.c: one rotary joint, an arm under gravity or a free rotor.
 *
 *     torque = inertia q'' + moment g sin(q - zero) + offset + friction
 *
 * with the angle sum sin(q - zero) = sin q cos zero - cos q sin zero it is linear
 * in inertia, moment cos zero, -moment sin zero, offset and the frictions.
 */
#include "math_inline.h"
#include "plant_internal.h"
#include "talus/math.h"

enum { INERTIA, GRAVITY_SIN, GRAVITY_COS, OFFSET, COULOMB, VISCOUS, BASES };
enum { P_INERTIA, P_MOMENT, P_ZERO, P_OFFSET, P_COULOMB, P_VISCOUS, PARAMETERS };

static void inverse(const tl_model *m, const tl_motion *motion, double torque[TL_MAX_JOINTS]) {
  double s, c;

  tl_sincos_inline(motion->q[0] - m->gravity_zero_rad, &s, &c);
  torque[0] = m->inertia_kg_m2 * motion->a[0] + m->gravity_moment_kg_m * (m->gravity_m_s2 * s) +
              m->torque_offset_Nm + m->drive[0].coulomb_Nm * motion->slip[0] +
              m->drive[0].viscous_Nms_rad * motion->v[0];
}

static double potential(const tl_model *m, const double q[TL_MAX_JOINTS]) {
  double s, c;

  /* 1 - cos x = 2 sin^2(x / 2) */
  tl_sincos_inline(0.5 * (q[0] - m->gravity_zero_rad), &s, &c);
  return 2.0 * m->gravity_m_s2 * m->gravity_moment_kg_m * (s * s);
}

static void inertia_matrix(const tl_model *m, const double q[TL_MAX_JOINTS], double *matrix) {
  (void)q;
  matrix[0] = m->inertia_kg_m2;
}

static void regressor(const tl_model *m, const tl_motion *motion, double *row, double known[TL_MAX_JOINTS]) {
  double s, c;

  (void)known;
  tl_sincos_inline(motion->q[0], &s, &c);
  row[INERTIA] = motion->a[0];
  row[GRAVITY_SIN] = m->gravity_m_s2 * s;
  row[GRAVITY_COS] = m->gravity_m_s2 * c;
  row[OFFSET] = 1.0;
  row[COULOMB] = motion->slip[0];
  row[VISCOUS] = motion->v[0];
}

static const tl_parameter parameter[PARAMETERS] = {
    [P_INERTIA] = {"inertia_kg_m2", offsetof(tl_model, inertia_kg_m2), 0.0, 0, 1},
    [P_MOMENT] = {"gravity_moment_kg_m", offsetof(tl_model, gravity_moment_kg_m), 0.0, 0, 0},
    [P_ZERO] = {"gravity_zero_rad", offsetof(tl_model, gravity_zero_rad), TL_UNBOUNDED, 1, 0},
    [P_OFFSET] = {"torque_offset_Nm", offsetof(tl_model, torque_offset_Nm), TL_UNBOUNDED, 0, 0},
    [P_COULOMB] = {"coulomb_Nm", TL_DRIVE_OFFSET(0, coulomb_Nm), 0.0, 0, 0},
    [P_VISCOUS] = {"viscous_Nms_rad", TL_DRIVE_OFFSET(0, viscous_Nms_rad), 0.0, 0, 0},
};

static const char *const base_name[BASES] = {
    [INERTIA] = "inertia",      [GRAVITY_SIN] = "gravity_sin", [GRAVITY_COS] = "gravity_cos",
    [OFFSET] = "torque_offset", [COULOMB] = "coulomb",         [VISCOUS] = "viscous"};

static void base_at(const tl_model *m, const double *p, double *base) {
  double s, c;

  (void)m;
  tl_sincos_inline(p[P_ZERO], &s, &c);
  base[INERTIA] = p[P_INERTIA];
  base[GRAVITY_SIN] = p[P_MOMENT] * c;
  base[GRAVITY_COS] = -p[P_MOMENT] * s;
  base[OFFSET] = p[P_OFFSET];
  base[COULOMB] = p[P_COULOMB];
  base[VISCOUS] = p[P_VISCOUS];
}

static void base_jacobian(const tl_model *m, double *jacobian) {
  double s, c;

  tl_sincos_inline(m->gravity_zero_rad, &s, &c);
#define J(base, column) jacobian[tl_entry(PARAMETERS, base, column)]
  J(INERTIA, P_INERTIA) = 1.0;
  J(GRAVITY_SIN, P_MOMENT) = c;
  J(GRAVITY_SIN, P_ZERO) = -m->gravity_moment_kg_m * s;
  J(GRAVITY_COS, P_MOMENT) = -s;
  J(GRAVITY_COS, P_ZERO) = -m->gravity_moment_kg_m * c;
  J(OFFSET, P_OFFSET) = 1.0;
  J(COULOMB, P_COULOMB) = 1.0;
  J(VISCOUS, P_VISCOUS) = 1.0;
#undef J
}

static const tl_key key[] = {
    {"gravity_m_s2", offsetof(tl_model, gravity_m_s2), TL_KEY_NOT_NEGATIVE, 0},
    {"inertia_kg_m2", offsetof(tl_model, inertia_kg_m2), TL_KEY_POSITIVE, 0},
    {"gravity_moment_kg_m", offsetof(tl_model, gravity_moment_kg_m), TL_KEY_NOT_NEGATIVE, 0},
    {"gravity_zero_rad", offsetof(tl_model, gravity_zero_rad), TL_KEY_ANY, 0},
    {"torque_offset_Nm", offsetof(tl_model, torque_offset_Nm), TL_KEY_ANY, 1},
    TL_DRIVE_KEYS("joint", 0),
    TL_FRICTION_KEYS("joint", 0),
};

#define BIT(name) TL_CHANNEL_BIT(TL_CHANNEL_##name)
#define MOTION (BIT(JOINT) | BIT(JOINT_VELOCITY))
#define DRIVE (BIT(JOINT_CURRENT) | BIT(JOINT_TORQUE))
#define OPTIONAL (BIT(VALID) | BIT(JOINT_LOAD) | BIT(JOINT_TEMP) | BIT(BUS))

const tl_plant_table tl_plant_pendulum = {
    .facts = {.name = "pendulum",
              .joints = 1,
              .joint = {"joint"},
              .coordinate_unit = "rad",
              .torque_unit = "Nm",
              .torque_name = "torque",
              .prediction = {"joint_torque_Nm"},
              .place = {TL_PLACE_SINGLE},
              .motor = 1,
              .channels = {.required = BIT(TIME),
                           .any_of = {MOTION, DRIVE},
                           .known = BIT(TIME) | MOTION | DRIVE | OPTIONAL},
              .sensors = {.position = {TL_CHANNEL_JOINT, TL_NO_CHANNEL},
                          .velocity = {TL_CHANNEL_JOINT_VELOCITY, TL_NO_CHANNEL},
                          .current = {TL_CHANNEL_JOINT_CURRENT, TL_NO_CHANNEL},
                          .torque = {TL_CHANNEL_JOINT_TORQUE, TL_NO_CHANNEL},
                          .temperature = {TL_CHANNEL_JOINT_TEMP, TL_NO_CHANNEL},
                          .encoder = TL_NO_CHANNELS,
                          .camera = TL_NO_CHANNELS,
                          .command = TL_NO_CHANNELS,
                          .load = TL_CHANNEL_JOINT_LOAD},
              .bench = {.multisine_amplitude = {0.8},
                        .ramp_amplitude = {0.4},
                        .ramp_speed = {0.3, 0.09, 0.03},
                        .ramp_acceleration = 5.0,
                        .speed = 8.0,
                        .acceleration = 100.0,
                        .drive_step = {2.0 * TL_PI / 262144.0}}},
    .key = key,
    .keys = sizeof key / sizeof key[0],
    .parameter = parameter,
    .parameters = PARAMETERS,
    .base = base_name,
    .bases = BASES,
    .base_at = base_at,
    .base_jacobian = base_jacobian,
    .inverse = inverse,
    .inertia_matrix = inertia_matrix,
    .potential = potential,
    .tilt = tl_tilt_by_turning,
    .regressor = regressor,
    .offset = {offsetof(tl_model, torque_offset_Nm)},
    .inertia = {offsetof(tl_model, inertia_kg_m2)},
    .gravity_moment = offsetof(tl_model, gravity_moment_kg_m),
    .gravity_zero = offsetof(tl_model, gravity_zero_rad),
};
