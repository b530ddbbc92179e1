/* plant.h: the three plants, their dynamics and what can be identified of them.
 *
 * Coordinates are the joints': for the leg q = (knee, ankle) with the shank's
 * absolute angle theta_s = q[0] and the foot's theta_f = q[0] + q[1], clockwise
 * positive from the vertical; a pendulum has its joint, a slider its travel.
 * Torque is what the recording shows: the leg's motor torques [N m], the
 * pendulum's joint torque [N m], the slider's force [N].
 *
 *     tl_motion now = {.q = {0.1, 0.0}, .v = {1.0, 0.0}, .a = {0.0, 0.0}};
 *     double torque_Nm[TL_MAX_JOINTS];
 *     tl_slip_from_velocity(&model, &now);
 *     tl_inverse(&model, &now, torque_Nm);
 *
 * Equation numbers are those of the source paper; the forms are Lagrange's,
 * docs/equations.md says where they differ from its print.
 */
#ifndef TALUS_PLANT_H
#define TALUS_PLANT_H

#include <stddef.h>

#include "talus/status.h"
#include "talus/transmission.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_MAX_JOINTS 2
#define TL_MAX_PARAMETERS 10 /* physical parameters that identification moves */
#define TL_MAX_BASE 9        /* linear (base) parameters */
#define TL_MAX_ROW 8         /* base parameters that one joint's row involves */

typedef enum tl_plant { TL_PLANT_LEG = 0, TL_PLANT_PENDULUM = 1, TL_PLANT_SLIDER = 2 } tl_plant;

/* TL_FORM_PAPER reproduces the paper's print (docs/equations.md), leg only. */
typedef enum tl_form { TL_FORM_LAGRANGE = 0, TL_FORM_PAPER = 1 } tl_form;

/* A joint's drive: transmission, motor and friction (at the joint). For a
 * slider only the friction counts, in N and N s/m. */
typedef struct tl_drive {
  tl_transmission transmission;
  double torque_constant_Nm_A;
  double rotor_inertia_kg_m2;
  double coulomb_Nm;
  double viscous_Nms_rad;
} tl_drive;

/* One struct for every plant; fields of other plants are ignored. */
typedef struct tl_model {
  tl_plant plant;
  tl_form form;
  double gravity_m_s2;
  /* leg */
  double shank_length_m, shank_mass_kg, shank_com_m, shank_inertia_kg_m2;
  double foot_mass_kg, foot_com_m, foot_inertia_kg_m2;
  double ankle_motor_mass_kg, ankle_motor_com_m;
  /* pendulum */
  double inertia_kg_m2, gravity_moment_kg_m, gravity_zero_rad, torque_offset_Nm;
  /* slider */
  double mass_kg, force_offset_N;
  /* leg: knee, ankle; pendulum: joint; slider: slider */
  tl_drive drive[TL_MAX_JOINTS];
} tl_model;

/* Joint motion at one instant. `slip` is the direction in which Coulomb
 * friction acts: +1 or -1 while sliding, anything between while a joint sticks.
 * In TL_FORM_PAPER the ankle's friction follows the foot's absolute speed, and
 * slip[1] is then the direction of v[0] + v[1]. */
typedef struct tl_motion {
  double q[TL_MAX_JOINTS];    /* [rad] or [m] */
  double v[TL_MAX_JOINTS];    /* [rad/s] or [m/s] */
  double a[TL_MAX_JOINTS];    /* [rad/s^2] or [m/s^2] */
  double slip[TL_MAX_JOINTS]; /* [-1, 1] */
} tl_motion;

/* Number of joints: 2, 1, 1; 0 for an unknown plant. */
int tl_joint_count(const tl_model *m);
/* "knee", "ankle"; "joint"; "slider"; NULL when out of range. */
const char *tl_joint_name(const tl_model *m, int joint);

/* The neutral model of a plant: every number 0, ratio 1, gravity 9.81. */
TL_CHECK tl_status tl_model_init(tl_model *m, tl_plant plant);
/* TL_ERR_RANGE when a mass, length, inertia or torque constant is not
 * positive, or gravity, a centre of mass, a gravity moment or a friction is
 * negative, or anything is not finite (the model file's ranges); TL_ERR_UNSUPPORTED
 * when the form is not the plant's, TL_ERR_ARGUMENT when a kind is unknown. */
TL_CHECK tl_status tl_model_check(const tl_model *m);

/* slip = sign of velocity, 0 at exactly 0 (ankle of TL_FORM_PAPER: of the foot's). */
void tl_slip_from_velocity(const tl_model *m, tl_motion *motion);

/* Inverse dynamics (12): torque[] that makes this motion. */
void tl_inverse(const tl_model *m, const tl_motion *motion, double torque[TL_MAX_JOINTS]);
/* n instants at once: arrays of length n for each joint, joint after joint
 * (q[j*n + i]); slip may be NULL, then it is as tl_slip_from_velocity says. Nullable: slip. */
void tl_inverse_batch(const tl_model *m, size_t n, const double *q, const double *v, const double *a,
                      const double *slip, double *torque);
/* Forward dynamics: fills motion->a from q, v, slip and torque.
 * TL_ERR_SINGULAR when the inertia matrix is not positive definite. */
TL_CHECK tl_status tl_forward(const tl_model *m, const double torque[TL_MAX_JOINTS], tl_motion *motion);
/* Generalised inertia matrix in joint coordinates, row-major 2 x 2 (1 x 1 in [0]). */
void tl_inertia_matrix(const tl_model *m, const double q[TL_MAX_JOINTS],
                       double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS]);
/* Joint-space torque: torque[] times the ratio at q (leg), or itself. */
void tl_joint_torque(const tl_model *m, const double q[TL_MAX_JOINTS], const double torque[TL_MAX_JOINTS],
                     double joint_torque[TL_MAX_JOINTS]);
/* Kinetic and potential energy [J] (potential 0 at rest, hanging; constant offsets
 * of torque and force do not count). */
void tl_energy(const tl_model *m, const tl_motion *motion, double *kinetic_J, double *potential_J);

/* ---- what is identified ------------------------------------------------ */

/* One physical parameter: where it stands in tl_model and what it may be. */
typedef struct tl_parameter {
  const char *name; /* "shank_com_m": unique within the plant */
  size_t offset;    /* of its double in tl_model */
  double lower;     /* physical bound, -infinity if none */
  int angle;        /* 1: an angle, every value within +-pi is as likely */
  int positive;     /* 1: must lie above `lower`, not on it */
} tl_parameter;

/* Physical parameters of the plant, in the order of the model file; n of them.
 * The leg's are the paper's ten. */
const tl_parameter *tl_parameters(const tl_model *m, int *n);
/* Read or write all of them; p has *n of tl_parameters. */
void tl_parameters_get(const tl_model *m, double *p);
void tl_parameters_set(tl_model *m, const double *p);

/* Base (linear) parameters: number, name, and value at the model's physical ones.
 *   leg       shank_inertia = I1 + ms ds^2 + mm dma^2, shank_moment = ms ds + mm dma,
 *             foot_moment = mf df, foot_inertia = If + mf df^2, ankle_rotor_inertia,
 *             knee_coulomb, knee_viscous, ankle_coulomb, ankle_viscous
 *   pendulum  inertia, gravity_sin = moment cos(zero), gravity_cos = -moment sin(zero),
 *             torque_offset, coulomb, viscous
 *   slider    mass, coulomb, viscous, force_offset
 * What the foot's mass does at the ankle (mf ls^2, mf ls g) is known, not fitted. */
int tl_base_count(const tl_model *m);
const char *tl_base_name(const tl_model *m, int base);
void tl_base_values(const tl_model *m, double *base);
/* The same at physical parameters p instead of the model's own; the rest of the model is as it is. */
void tl_base_at(const tl_model *m, const double *p, double *base);
/* d base / d parameter, row-major (base_count x parameter count). */
void tl_base_jacobian(const tl_model *m, double *jacobian);

/* The base parameters that joint's row involves: their indices; returns how many (<= TL_MAX_ROW). */
int tl_row_index(const tl_model *m, int joint, int index[TL_MAX_ROW]);
/* One instant's regressor: torque[joint] = known + sum over k of row[k] base[index[k]].
 * `row` is (TL_MAX_ROW) for each joint: row[joint * TL_MAX_ROW + k], 0 where k is unused.
 * Depends on the known numbers only (masses, shank length, gravity, transmissions), not
 * on what is identified. */
void tl_regressor(const tl_model *m, const tl_motion *motion, double row[TL_MAX_JOINTS * TL_MAX_ROW],
                  double known[TL_MAX_JOINTS]);

#ifdef __cplusplus
}
#endif
#endif
