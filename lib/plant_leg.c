/* plant_leg.c: dynamics of the leg in joint coordinates, docs/equations.md (12).
 *
 * With q = (knee, ankle), theta_s = q0, theta_f = q0 + q1, the sum of rows s and
 * f is the knee's equation and row f the ankle's:
 *     knee = M11 q0'' + M12 q1'' - H sin q1 (2 q0' q1' + q1'^2) + g terms + friction
 *     ankle = M12 q0'' + M22 q1'' + H sin q1 q0'^2 + Ima ka ka' q1'^2 + g term + friction
 *     M11 = J + F + 2 H cos q1, M12 = F + H cos q1, M22 = F + Ima ka^2
 *     J = I1 + ms ds^2 + mm dma^2 + mf ls^2, F = If + mf df^2, H = mf ls df.
 * Everything here is a sum of base parameters times factors that depend on the
 * motion alone; inverse, forward and regressor share these factors.
 */
#include <math.h>

#include "math_inline.h"
#include "plant_internal.h"
#include "talus/math.h"
#include "transmission_internal.h"

/* the paper's ten, in its order */
enum {
  P_MOTOR_COM,
  P_FOOT_COM,
  P_SHANK_COM,
  P_SHANK_INERTIA,
  P_ROTOR_INERTIA,
  P_FOOT_INERTIA,
  P_KNEE_COULOMB,
  P_KNEE_VISCOUS,
  P_ANKLE_COULOMB,
  P_ANKLE_VISCOUS,
  PARAMETERS
};

/* columns of the knee's and of the ankle's row */
enum {
  K_SHANK_INERTIA,
  K_SHANK_MOMENT,
  K_FOOT_MOMENT,
  K_FOOT_INERTIA,
  K_KNEE_COULOMB,
  K_KNEE_VISCOUS,
  KNEE_COLUMNS,
  K_ANKLE_COULOMB = KNEE_COLUMNS, /* only the paper's form has the ankle's friction in the knee's row */
  K_ANKLE_VISCOUS,
  PAPER_KNEE_COLUMNS
};
enum { A_FOOT_MOMENT, A_FOOT_INERTIA, A_ROTOR_INERTIA, A_ANKLE_COULOMB, A_ANKLE_VISCOUS, ANKLE_COLUMNS };

/* what depends on the joint angles alone */
typedef struct leg_pose {
  double gravity_shank;  /* g sin theta_s */
  double gravity_foot;   /* g sin theta_f */
  double ls_cos, ls_sin; /* ls cos q1, ls sin q1 */
  double ratio[2];
  double slope; /* dka / dq1 */
} leg_pose;

/* factors of the base parameters in the joint torques; what the motion itself gives is left there */
typedef struct leg_factors {
  double foot_moment_knee, foot_moment_ankle;
  double foot_acceleration; /* theta_f'' */
  double rotor;             /* Ima in the ankle's torque */
  double ankle_speed;       /* that the ankle's friction sees */
  double ankle_in_knee;     /* how often the knee's row counts its friction: 0, paper 2 */
} leg_factors;

static inline void ratio_at(const tl_drive *d, double q, double sin_q, double cos_q, double *ratio,
                            double *slope) {
  if (d->transmission.kind == TL_TRANSMISSION_FIXED) {
    *ratio = d->transmission.ratio;
    *slope = 0.0;
  } else if (d->transmission.kind == TL_TRANSMISSION_SCREW_LINKAGE) {
    tl_linkage_ratio(&d->transmission, sin_q, cos_q, ratio, slope);
  } else {
    tl_transmission_ratio_sc(&d->transmission, q, sin_q, cos_q, ratio, slope);
  }
}

/* the pose but for the ratios */
static inline leg_pose turned(const tl_model *m, double sin_s, double cos_s, double sin_a, double cos_a) {
  leg_pose p;

  p.gravity_shank = m->gravity_m_s2 * sin_s;
  p.gravity_foot = m->gravity_m_s2 * (sin_s * cos_a + cos_s * sin_a);
  p.ls_cos = m->shank_length_m * cos_a;
  p.ls_sin = m->shank_length_m * sin_a;
  return p;
}

static inline leg_pose pose_at(const tl_model *m, const double q[2]) {
  double sine[2], cosine[2], knee_slope;
  leg_pose p;

  tl_sincos_two(q[0], q[1], sine, cosine);
  p = turned(m, sine[0], cosine[0], sine[1], cosine[1]);
  /* I1 holds the knee's rotor, so the slope of its ratio moves nothing */
  ratio_at(&m->drive[0], q[0], sine[0], cosine[0], &p.ratio[0], &knee_slope);
  ratio_at(&m->drive[1], q[1], sine[1], cosine[1], &p.ratio[1], &p.slope);
  return p;
}

static inline leg_factors factors_at(const tl_model *m, const leg_pose *p, const tl_motion *s) {
  const double *v = s->v, *a = s->a;
  int paper = m->form == TL_FORM_PAPER;
  double rotor_speed2 = p->ratio[1] * p->slope * v[1] * v[1];
  leg_factors f;

  f.foot_acceleration = a[0] + a[1];
  f.foot_moment_knee =
      p->ls_cos * (a[0] + f.foot_acceleration) - p->ls_sin * ((v[0] + v[0] + v[1]) * v[1]) + p->gravity_foot;
  f.foot_moment_ankle = p->ls_cos * a[0] + p->ls_sin * (v[0] * v[0]) + p->gravity_foot;
  /* the paper's print: -3 for +1; friction on the foot's own speed and, by its sign, twice in the knee's */
  f.rotor = p->ratio[1] * p->ratio[1] * a[1] + (paper ? -3.0 * rotor_speed2 : rotor_speed2);
  f.ankle_speed = paper ? v[0] + v[1] : v[1];
  f.ankle_in_knee = paper ? 2.0 : 0.0;
  return f;
}

static inline void base_at(const tl_model *m, const double *p, double *base) {
  double shank = m->shank_mass_kg * p[P_SHANK_COM], motor = m->ankle_motor_mass_kg * p[P_MOTOR_COM];
  double foot = m->foot_mass_kg * p[P_FOOT_COM];

  base[TL_LEG_SHANK_INERTIA] = p[P_SHANK_INERTIA] + shank * p[P_SHANK_COM] + motor * p[P_MOTOR_COM];
  base[TL_LEG_SHANK_MOMENT] = shank + motor;
  base[TL_LEG_FOOT_MOMENT] = foot;
  base[TL_LEG_FOOT_INERTIA] = p[P_FOOT_INERTIA] + foot * p[P_FOOT_COM];
  base[TL_LEG_ROTOR_INERTIA] = p[P_ROTOR_INERTIA];
  base[TL_LEG_KNEE_COULOMB] = p[P_KNEE_COULOMB];
  base[TL_LEG_KNEE_VISCOUS] = p[P_KNEE_VISCOUS];
  base[TL_LEG_ANKLE_COULOMB] = p[P_ANKLE_COULOMB];
  base[TL_LEG_ANKLE_VISCOUS] = p[P_ANKLE_VISCOUS];
}

/* at the model's own parameters, without a detour through memory */
static inline void base_values(const tl_model *m, double *base) {
  const double p[PARAMETERS] = {
      [P_MOTOR_COM] = m->ankle_motor_com_m,
      [P_FOOT_COM] = m->foot_com_m,
      [P_SHANK_COM] = m->shank_com_m,
      [P_SHANK_INERTIA] = m->shank_inertia_kg_m2,
      [P_ROTOR_INERTIA] = m->drive[1].rotor_inertia_kg_m2,
      [P_FOOT_INERTIA] = m->foot_inertia_kg_m2,
      [P_KNEE_COULOMB] = m->drive[0].coulomb_Nm,
      [P_KNEE_VISCOUS] = m->drive[0].viscous_Nms_rad,
      [P_ANKLE_COULOMB] = m->drive[1].coulomb_Nm,
      [P_ANKLE_VISCOUS] = m->drive[1].viscous_Nms_rad,
  };

  base_at(m, p, base);
}

/* the foot's mass at the ankle, which no parameter moves */
static inline double known_knee_torque(const tl_model *m, const leg_pose *p, double knee_acceleration) {
  return m->foot_mass_kg * m->shank_length_m * (m->shank_length_m * knee_acceleration + p->gravity_shank);
}

static inline void joint_torques(const tl_model *m, const leg_pose *p, const tl_motion *s, double torque[2]) {
  leg_factors f = factors_at(m, p, s);
  double b[TL_LEG_BASES], ankle_friction, foot_turning;

  base_values(m, b);
  ankle_friction = b[TL_LEG_ANKLE_COULOMB] * s->slip[1] + b[TL_LEG_ANKLE_VISCOUS] * f.ankle_speed;
  foot_turning = b[TL_LEG_FOOT_INERTIA] * f.foot_acceleration;
  torque[0] = b[TL_LEG_SHANK_INERTIA] * s->a[0] + b[TL_LEG_SHANK_MOMENT] * p->gravity_shank +
              b[TL_LEG_FOOT_MOMENT] * f.foot_moment_knee + foot_turning +
              b[TL_LEG_KNEE_COULOMB] * s->slip[0] + b[TL_LEG_KNEE_VISCOUS] * s->v[0] +
              f.ankle_in_knee * ankle_friction + known_knee_torque(m, p, s->a[0]);
  torque[1] = b[TL_LEG_FOOT_MOMENT] * f.foot_moment_ankle + foot_turning + b[TL_LEG_ROTOR_INERTIA] * f.rotor +
              ankle_friction;
}

static void inverse(const tl_model *m, const tl_motion *motion, double torque[TL_MAX_JOINTS]) {
  leg_pose p = pose_at(m, motion->q);
  double joint[2];

  joint_torques(m, &p, motion, joint);
  torque[0] = joint[0] / p.ratio[0];
  torque[1] = joint[1] / p.ratio[1];
}

static void matrix_at(const tl_model *m, const leg_pose *p, double matrix[4]) {
  double b[TL_LEG_BASES], foot_coupling;

  base_values(m, b);
  foot_coupling = b[TL_LEG_FOOT_MOMENT] * p->ls_cos;
  matrix[3] = b[TL_LEG_FOOT_INERTIA] + b[TL_LEG_ROTOR_INERTIA] * (p->ratio[1] * p->ratio[1]);
  matrix[1] = matrix[2] = b[TL_LEG_FOOT_INERTIA] + foot_coupling;
  matrix[0] = b[TL_LEG_SHANK_INERTIA] + m->foot_mass_kg * (m->shank_length_m * m->shank_length_m) +
              b[TL_LEG_FOOT_INERTIA] + 2.0 * foot_coupling;
}

static void inertia_matrix(const tl_model *m, const double q[TL_MAX_JOINTS], double *matrix) {
  leg_pose p = pose_at(m, q);

  matrix_at(m, &p, matrix);
}

static tl_status forward(const tl_model *m, const double torque[TL_MAX_JOINTS], tl_motion *motion) {
  leg_pose p = pose_at(m, motion->q);
  tl_motion at_rest = *motion;
  double matrix[4], bias[2], left[2], lift, pivot;

  /* what is left for acceleration after everything else has had its share */
  at_rest.a[0] = at_rest.a[1] = 0.0;
  joint_torques(m, &p, &at_rest, bias);
  left[0] = torque[0] * p.ratio[0] - bias[0];
  left[1] = torque[1] * p.ratio[1] - bias[1];

  /* M = L D L': the matrix is positive definite when both pivots are */
  matrix_at(m, &p, matrix);
  if (!(matrix[0] > 0.0)) return TL_ERR_SINGULAR;
  lift = matrix[1] / matrix[0];
  pivot = matrix[3] - lift * matrix[1];
  if (!(pivot > 0.0)) return TL_ERR_SINGULAR;
  motion->a[1] = (left[1] - lift * left[0]) / pivot;
  motion->a[0] = left[0] / matrix[0] - lift * motion->a[1];
  return TL_OK;
}

static void ratios(const tl_model *m, const double q[TL_MAX_JOINTS], double ratio[TL_MAX_JOINTS]) {
  leg_pose p = pose_at(m, q);

  ratio[0] = p.ratio[0];
  ratio[1] = p.ratio[1];
}

static double potential(const tl_model *m, const double q[TL_MAX_JOINTS]) {
  double b[TL_LEG_BASES], half_s, half_f, c;

  /* 1 - cos x = 2 sin^2(x / 2) keeps its digits near 0 */
  base_values(m, b);
  tl_sincos_inline(0.5 * q[0], &half_s, &c);
  tl_sincos_inline(0.5 * (q[0] + q[1]), &half_f, &c);
  return 2.0 * m->gravity_m_s2 *
         ((b[TL_LEG_SHANK_MOMENT] + m->foot_mass_kg * m->shank_length_m) * (half_s * half_s) +
          b[TL_LEG_FOOT_MOMENT] * (half_f * half_f));
}

/* ---- regressor ----------------------------------------------------------- */

/* what stands before the base parameters, column c at [c * stride] */
static inline void put_row(const tl_model *m, const leg_pose *p, const tl_motion *s, double *knee,
                           double *ankle, size_t stride, double *knee_known) {
  leg_factors f = factors_at(m, p, s);
  double per_knee = 1.0 / p->ratio[0], per_ankle = 1.0 / p->ratio[1];

  knee[K_SHANK_INERTIA * stride] = s->a[0] * per_knee;
  knee[K_SHANK_MOMENT * stride] = p->gravity_shank * per_knee;
  knee[K_FOOT_MOMENT * stride] = f.foot_moment_knee * per_knee;
  knee[K_FOOT_INERTIA * stride] = f.foot_acceleration * per_knee;
  knee[K_KNEE_COULOMB * stride] = s->slip[0] * per_knee;
  knee[K_KNEE_VISCOUS * stride] = s->v[0] * per_knee;
  knee[K_ANKLE_COULOMB * stride] = f.ankle_in_knee * s->slip[1] * per_knee;
  knee[K_ANKLE_VISCOUS * stride] = f.ankle_in_knee * f.ankle_speed * per_knee;
  ankle[A_FOOT_MOMENT * stride] = f.foot_moment_ankle * per_ankle;
  ankle[A_FOOT_INERTIA * stride] = f.foot_acceleration * per_ankle;
  ankle[A_ROTOR_INERTIA * stride] = f.rotor * per_ankle;
  ankle[A_ANKLE_COULOMB * stride] = s->slip[1] * per_ankle;
  ankle[A_ANKLE_VISCOUS * stride] = f.ankle_speed * per_ankle;
  *knee_known = known_knee_torque(m, p, s->a[0]) * per_knee;
}

static void regressor(const tl_model *m, const tl_motion *motion, double *row, double known[TL_MAX_JOINTS]) {
  leg_pose p = pose_at(m, motion->q);

  put_row(m, &p, motion, row, row + TL_MAX_ROW, 1, known);
}

/* ---- regressor of many instants ------------------------------------------ */

/* sines and ratios of a block of a motion */
typedef struct leg_angles {
  double sine[2][TL_BLOCK_ROWS], cosine[2][TL_BLOCK_ROWS], ratio[2][TL_BLOCK_ROWS], slope[2][TL_BLOCK_ROWS];
} leg_angles;

static void ratios_at(const tl_drive *d, const double *restrict q, size_t n, leg_angles *restrict at,
                      int joint) {
  double *restrict ratio = at->ratio[joint], *restrict slope = at->slope[joint];
  const double *restrict sine = at->sine[joint], *restrict cosine = at->cosine[joint];
  size_t i;

  /* the usual ones without a branch in their loops */
  if (d->transmission.kind == TL_TRANSMISSION_SCREW_LINKAGE)
    for (i = 0; i < n; i++) tl_linkage_ratio(&d->transmission, sine[i], cosine[i], &ratio[i], &slope[i]);
  else
    for (i = 0; i < n; i++) ratio_at(d, q[i], sine[i], cosine[i], &ratio[i], &slope[i]);
}

/* instant i of the block; what is known of the ankle's torque is 0 */
static inline void put_instant(const tl_model *m, const tl_motion_block *s, const leg_angles *at, size_t i,
                               tl_regressor_block *rows) {
  leg_pose p = turned(m, at->sine[0][i], at->cosine[0][i], at->sine[1][i], at->cosine[1][i]);
  tl_motion now = {{s->q[0][i], s->q[1][i]},
                   {s->v[0][i], s->v[1][i]},
                   {s->a[0][i], s->a[1][i]},
                   {s->slip[0][i], s->slip[1][i]}};

  p.ratio[0] = at->ratio[0][i];
  p.ratio[1] = at->ratio[1][i];
  p.slope = at->slope[1][i];
  put_row(m, &p, &now, &rows->column[0][0][i], &rows->column[1][0][i], TL_BLOCK_ROWS, &rows->known[0][i]);
  rows->known[1][i] = 0.0;
}

static void leg_rows(const tl_model *restrict m, const tl_motion_block *restrict s, size_t n,
                     tl_regressor_block *restrict rows) {
  leg_angles at;
  size_t i;
  int j;

  /* in steps that each keep to one kind of arithmetic, so that they run in vector registers */
  for (j = 0; j < 2; j++) {
    tl_sincos_many(s->q[j], n, at.sine[j], at.cosine[j]);
    ratios_at(&m->drive[j], s->q[j], n, &at, j);
  }
  for (i = 0; i < n; i++) put_instant(m, s, &at, i, rows);
}

/* ---- what is identified ------------------------------------------------ */

static const tl_parameter leg_parameter[PARAMETERS] = {
    [P_MOTOR_COM] = {"ankle_motor_com_m", offsetof(tl_model, ankle_motor_com_m), 0.0, 0, 0},
    [P_FOOT_COM] = {"foot_com_m", offsetof(tl_model, foot_com_m), 0.0, 0, 0},
    [P_SHANK_COM] = {"shank_com_m", offsetof(tl_model, shank_com_m), 0.0, 0, 0},
    [P_SHANK_INERTIA] = {"shank_inertia_kg_m2", offsetof(tl_model, shank_inertia_kg_m2), 0.0, 0, 1},
    [P_ROTOR_INERTIA] = {"ankle_rotor_inertia_kg_m2", TL_DRIVE_OFFSET(1, rotor_inertia_kg_m2), 0.0, 0, 1},
    [P_FOOT_INERTIA] = {"foot_inertia_kg_m2", offsetof(tl_model, foot_inertia_kg_m2), 0.0, 0, 1},
    [P_KNEE_COULOMB] = {"knee_coulomb_Nm", TL_DRIVE_OFFSET(0, coulomb_Nm), 0.0, 0, 0},
    [P_KNEE_VISCOUS] = {"knee_viscous_Nms_rad", TL_DRIVE_OFFSET(0, viscous_Nms_rad), 0.0, 0, 0},
    [P_ANKLE_COULOMB] = {"ankle_coulomb_Nm", TL_DRIVE_OFFSET(1, coulomb_Nm), 0.0, 0, 0},
    [P_ANKLE_VISCOUS] = {"ankle_viscous_Nms_rad", TL_DRIVE_OFFSET(1, viscous_Nms_rad), 0.0, 0, 0},
};

static const char *const leg_base[TL_LEG_BASES] = {
    [TL_LEG_SHANK_INERTIA] = "shank_inertia",       [TL_LEG_SHANK_MOMENT] = "shank_moment",
    [TL_LEG_FOOT_MOMENT] = "foot_moment",           [TL_LEG_FOOT_INERTIA] = "foot_inertia",
    [TL_LEG_ROTOR_INERTIA] = "ankle_rotor_inertia", [TL_LEG_KNEE_COULOMB] = "knee_coulomb",
    [TL_LEG_KNEE_VISCOUS] = "knee_viscous",         [TL_LEG_ANKLE_COULOMB] = "ankle_coulomb",
    [TL_LEG_ANKLE_VISCOUS] = "ankle_viscous",
};

static void leg_base_at(const tl_model *m, const double *p, double *base) {
  base_at(m, p, base);
}

static void leg_base_jacobian(const tl_model *m, double *jacobian) {
#define J(base, parameter) jacobian[tl_entry(PARAMETERS, base, parameter)]
  J(TL_LEG_SHANK_INERTIA, P_SHANK_INERTIA) = 1.0;
  J(TL_LEG_SHANK_INERTIA, P_SHANK_COM) = 2.0 * m->shank_mass_kg * m->shank_com_m;
  J(TL_LEG_SHANK_INERTIA, P_MOTOR_COM) = 2.0 * m->ankle_motor_mass_kg * m->ankle_motor_com_m;
  J(TL_LEG_SHANK_MOMENT, P_SHANK_COM) = m->shank_mass_kg;
  J(TL_LEG_SHANK_MOMENT, P_MOTOR_COM) = m->ankle_motor_mass_kg;
  J(TL_LEG_FOOT_MOMENT, P_FOOT_COM) = m->foot_mass_kg;
  J(TL_LEG_FOOT_INERTIA, P_FOOT_INERTIA) = 1.0;
  J(TL_LEG_FOOT_INERTIA, P_FOOT_COM) = 2.0 * m->foot_mass_kg * m->foot_com_m;
  J(TL_LEG_ROTOR_INERTIA, P_ROTOR_INERTIA) = 1.0;
  J(TL_LEG_KNEE_COULOMB, P_KNEE_COULOMB) = 1.0;
  J(TL_LEG_KNEE_VISCOUS, P_KNEE_VISCOUS) = 1.0;
  J(TL_LEG_ANKLE_COULOMB, P_ANKLE_COULOMB) = 1.0;
  J(TL_LEG_ANKLE_VISCOUS, P_ANKLE_VISCOUS) = 1.0;
#undef J
}

static int leg_row_index(const tl_model *m, int joint, int *index) {
  static const int knee[PAPER_KNEE_COLUMNS] = {
      [K_SHANK_INERTIA] = TL_LEG_SHANK_INERTIA, [K_SHANK_MOMENT] = TL_LEG_SHANK_MOMENT,
      [K_FOOT_MOMENT] = TL_LEG_FOOT_MOMENT,     [K_FOOT_INERTIA] = TL_LEG_FOOT_INERTIA,
      [K_KNEE_COULOMB] = TL_LEG_KNEE_COULOMB,   [K_KNEE_VISCOUS] = TL_LEG_KNEE_VISCOUS,
      [K_ANKLE_COULOMB] = TL_LEG_ANKLE_COULOMB, [K_ANKLE_VISCOUS] = TL_LEG_ANKLE_VISCOUS,
  };
  static const int ankle[ANKLE_COLUMNS] = {
      [A_FOOT_MOMENT] = TL_LEG_FOOT_MOMENT,     [A_FOOT_INERTIA] = TL_LEG_FOOT_INERTIA,
      [A_ROTOR_INERTIA] = TL_LEG_ROTOR_INERTIA, [A_ANKLE_COULOMB] = TL_LEG_ANKLE_COULOMB,
      [A_ANKLE_VISCOUS] = TL_LEG_ANKLE_VISCOUS,
  };
  int n = joint ? ANKLE_COLUMNS : m->form == TL_FORM_PAPER ? PAPER_KNEE_COLUMNS : KNEE_COLUMNS, i;

  for (i = 0; i < n; i++) index[i] = joint ? ankle[i] : knee[i];
  return n;
}

/* ---- model file and sensors ---------------------------------------------- */

#define NUMBER(key, member, kind)                                                                            \
  { key, offsetof(tl_model, member), kind, 0 }

static const tl_key leg_key[] = {
    NUMBER("gravity_m_s2", gravity_m_s2, TL_KEY_NOT_NEGATIVE),
    NUMBER("shank.length_m", shank_length_m, TL_KEY_POSITIVE),
    NUMBER("shank.mass_kg", shank_mass_kg, TL_KEY_POSITIVE),
    NUMBER("shank.com_m", shank_com_m, TL_KEY_NOT_NEGATIVE),
    NUMBER("shank.inertia_kg_m2", shank_inertia_kg_m2, TL_KEY_POSITIVE),
    NUMBER("foot.mass_kg", foot_mass_kg, TL_KEY_POSITIVE),
    NUMBER("foot.com_m", foot_com_m, TL_KEY_NOT_NEGATIVE),
    NUMBER("foot.inertia_kg_m2", foot_inertia_kg_m2, TL_KEY_POSITIVE),
    NUMBER("ankle_motor.mass_kg", ankle_motor_mass_kg, TL_KEY_POSITIVE),
    NUMBER("ankle_motor.com_m", ankle_motor_com_m, TL_KEY_NOT_NEGATIVE),
    TL_DRIVE_KEYS("knee", 0),
    TL_FRICTION_KEYS("knee", 0),
    TL_DRIVE_KEYS("ankle", 1),
    {"ankle.rotor_inertia_kg_m2", TL_DRIVE_OFFSET(1, rotor_inertia_kg_m2), TL_KEY_POSITIVE, 0},
    TL_FRICTION_KEYS("ankle", 1),
};

#define BIT(name) TL_CHANNEL_BIT(TL_CHANNEL_##name)
#define REQUIRED                                                                                             \
  (BIT(TIME) | BIT(KNEE_MOTOR) | BIT(ANKLE_MOTOR) | BIT(ANKLE_JOINT) | BIT(KNEE_CURRENT) | BIT(ANKLE_CURRENT))
#define OPTIONAL (BIT(VALID) | BIT(SHANK) | BIT(FOOT) | BIT(KNEE_TEMP) | BIT(ANKLE_TEMP) | BIT(BUS))

const tl_plant_table tl_plant_leg = {
    .facts = {.name = "leg",
              .joints = 2,
              .joint = {"knee", "ankle"},
              .coordinate_unit = "rad",
              .torque_unit = "Nm",
              .torque_name = "torque",
              .prediction = {"knee_motor_torque_Nm", "ankle_motor_torque_Nm"},
              .place = {TL_PLACE_KNEE, TL_PLACE_ANKLE, TL_PLACE_BASE},
              .motor = 1,
              .paper_form = 1,
              .leg_bus = 1,
              .channels = {.required = REQUIRED, .known = REQUIRED | OPTIONAL},
              .sensors = {.at_motor = 1,
                          .position = {TL_CHANNEL_KNEE_MOTOR, TL_CHANNEL_ANKLE_MOTOR},
                          .velocity = TL_NO_CHANNELS,
                          .current = {TL_CHANNEL_KNEE_CURRENT, TL_CHANNEL_ANKLE_CURRENT},
                          .torque = TL_NO_CHANNELS,
                          .temperature = {TL_CHANNEL_KNEE_TEMP, TL_CHANNEL_ANKLE_TEMP},
                          .encoder = {TL_NO_CHANNEL, TL_CHANNEL_ANKLE_JOINT},
                          .camera = {TL_CHANNEL_SHANK, TL_CHANNEL_FOOT},
                          .command = TL_NO_CHANNELS,
                          .load = TL_NO_CHANNEL},
              .bench = {.multisine_amplitude = {0.5, 0.35},
                        .ramp_amplitude = {0.4, 0.3},
                        .ramp_speed = {0.3, 0.09, 0.03},
                        .ramp_acceleration = 5.0,
                        .speed = 8.0,
                        .acceleration = 100.0,
                        .position = {1.0, 0.5},
                        .drive_step = {2.0 * TL_PI / 16384.0, 2.0 * TL_PI / 16384.0},
                        .current_noise_A = {0.020, 0.005}}},
    .key = leg_key,
    .keys = sizeof leg_key / sizeof leg_key[0],
    .parameter = leg_parameter,
    .parameters = PARAMETERS,
    .base = leg_base,
    .bases = TL_LEG_BASES,
    .base_at = leg_base_at,
    .base_jacobian = leg_base_jacobian,
    .inverse = inverse,
    .forward = forward,
    .inertia_matrix = inertia_matrix,
    .potential = potential,
    .tilt = tl_tilt_by_turning,
    .ratios = ratios,
    .regressor = regressor,
    .rows = leg_rows,
    .row_index = leg_row_index,
    /* the knee's rotor is reflected into the shank's inertia */
    .inertia = {offsetof(tl_model, shank_inertia_kg_m2)},
    .rotor = {0, 1},
};
