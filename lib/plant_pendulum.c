/* plant_pendulum.c: one rotary joint, an arm under gravity or a free rotor.
 *
 *     torque = inertia q'' + moment g sin(q - zero) + offset + friction
 *
 * with the angle sum sin(q - zero) = sin q cos zero - cos q sin zero it is linear
 * in inertia, moment cos zero, -moment sin zero, offset and the frictions.
 */
#include "math_inline.h"
#include "plant_internal.h"

enum { INERTIA, GRAVITY_SIN, GRAVITY_COS, OFFSET, COULOMB, VISCOUS, BASES };
enum { P_INERTIA, P_MOMENT, P_ZERO, P_OFFSET, P_COULOMB, P_VISCOUS, PARAMETERS };

void tl_pendulum_inverse(const tl_model *m, const tl_motion *motion, double torque[TL_MAX_JOINTS]) {
  double s, c;

  tl_sincos_inline(motion->q[0] - m->gravity_zero_rad, &s, &c);
  torque[0] = m->inertia_kg_m2 * motion->a[0] + m->gravity_moment_kg_m * (m->gravity_m_s2 * s) +
              m->torque_offset_Nm + m->drive[0].coulomb_Nm * motion->slip[0] +
              m->drive[0].viscous_Nms_rad * motion->v[0];
}

double tl_pendulum_potential(const tl_model *m, const double q[TL_MAX_JOINTS]) {
  double s, c;

  /* 1 - cos x = 2 sin^2(x / 2) */
  tl_sincos_inline(0.5 * (q[0] - m->gravity_zero_rad), &s, &c);
  return 2.0 * m->gravity_m_s2 * m->gravity_moment_kg_m * (s * s);
}

void tl_pendulum_regressor(const tl_model *m, const tl_motion *motion, double *row) {
  double s, c;

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

static const char *const base_name[BASES] = {"inertia",       "gravity_sin", "gravity_cos",
                                             "torque_offset", "coulomb",     "viscous"};

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
#define J(base, column) jacobian[(base)*PARAMETERS + (column)]
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

const tl_plant_table tl_pendulum_table = {
    {"joint", 0}, 1, parameter, PARAMETERS, base_name, BASES, base_at, base_jacobian,
};
