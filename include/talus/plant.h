/* plant.h: the plants, their dynamics and what can be identified of them.
 *
 * Coordinates are the joints': for the leg q = (knee, ankle) with the shank's
 * absolute angle theta_s = q[0] and the foot's theta_f = q[0] + q[1], clockwise
 * positive from the vertical; a pendulum has its joint, a slider its travel.
 * Torque is what the recording shows: the leg's motor torques [N m], the
 * pendulum's joint torque [N m], the slider's force [N].
 *
 *     tl_model arm;
 *     if (tl_model_init(&arm, TL_PLANT_PENDULUM) != TL_OK) return 1;
 *     arm.inertia_kg_m2 = 0.05;
 *     arm.gravity_moment_kg_m = 0.2;
 *     arm.drive[0].coulomb_Nm = 0.3;
 *     tl_motion now = {.q = {TL_PI / 6.0}, .v = {1.0}, .a = {2.0}};
 *     double torque_Nm[TL_MAX_JOINTS];
 *     tl_slip_from_velocity(&arm, &now);
 *     tl_inverse(&arm, &now, torque_Nm);
 *     printf("%.3f\n", torque_Nm[0]); // prints 1.381
 *
 * Equation numbers are those of the source paper; the forms are Lagrange's,
 * docs/equations.md says where they differ from its print.
 */
#ifndef TALUS_PLANT_H
#define TALUS_PLANT_H

#include <stddef.h>
#include <stdint.h>

#include "talus/channel.h"
#include "talus/status.h"
#include "talus/transmission.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_MAX_JOINTS 2
#define TL_MAX_PARAMETERS 10 /* physical parameters that identification moves */
#define TL_MAX_BASE 9        /* linear (base) parameters */
#define TL_MAX_ROW 8         /* base parameters that one joint's row involves */
#define TL_MAX_NUMBERS 8     /* numbers of a plant that has no members of its own in tl_model */

/* Every plant: its enumerator TL_PLANT_LEG = 0, ..., and its file lib/plant_leg.c, .... docs/plants.md says
 * how to add one. */
#define TL_PLANTS(row) row(LEG, leg) row(PENDULUM, pendulum) row(SLIDER, slider)
#define TL_PLANT_ENUMERATOR(upper, lower) TL_PLANT_##upper,
typedef enum tl_plant { TL_PLANTS(TL_PLANT_ENUMERATOR) TL_PLANT_COUNT } tl_plant;

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
  /* another plant; its file says which is which */
  double number[TL_MAX_NUMBERS];
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

/* ---- what is known of a plant without its numbers ------------------------ */

/* What a plant's recording holds; each member is a set of TL_CHANNEL_BIT. */
typedef struct tl_channel_set {
  uint32_t known;     /* required, optional, and those of any_of */
  uint32_t required;  /* every one must be there */
  uint32_t any_of[2]; /* of each set that is not empty, at least one must be there */
} tl_channel_set;

/* What a recording can show of each joint; TL_NO_CHANNEL where nothing does. */
typedef struct tl_sensors {
  int at_motor; /* 1: position and torque are the motor's; 0: the joint's */
  tl_channel position[TL_MAX_JOINTS], velocity[TL_MAX_JOINTS];
  tl_channel current[TL_MAX_JOINTS], torque[TL_MAX_JOINTS]; /* a recorded torque is preferred to a current */
  tl_channel temperature[TL_MAX_JOINTS];
  tl_channel encoder[TL_MAX_JOINTS]; /* an absolute one at the joint, beside the motor's */
  tl_channel camera[TL_MAX_JOINTS];  /* absolute angle of the link that the joint moves */
  tl_channel command[TL_MAX_JOINTS]; /* position set-point */
  tl_channel load;                   /* a torque sensor at the output */
} tl_sensors;

/* Excitation that suits a plant, and its bench in simulation. */
typedef struct tl_plant_bench {
  double multisine_amplitude[TL_MAX_JOINTS]; /* [rad] or [m] */
  double ramp_amplitude[TL_MAX_JOINTS];      /* [rad] or [m] */
  double ramp_speed[3];                      /* [rad/s] or [m/s] */
  double ramp_acceleration;                  /* [rad/s^2] or [m/s^2] */
  double speed, acceleration;                /* limits of every joint, same units */
  double position[TL_MAX_JOINTS];            /* limit to both sides [rad] or [m]; 0: none */
  double drive_step[TL_MAX_JOINTS];          /* resolution of the drives' encoders [rad] or [m] */
  double current_noise_A[TL_MAX_JOINTS];     /* standard deviation; 0: a share of the current limit */
} tl_plant_bench;

/* Where an effect can stand: kinds of joints, and the base that carries the plant. */
enum { TL_PLACE_KNEE = 1, TL_PLACE_ANKLE = 2, TL_PLACE_SINGLE = 4, TL_PLACE_BASE = 8 };

typedef struct tl_facts {
  const char *name; /* "leg": as in a model file */
  int joints;
  const char *joint[TL_MAX_JOINTS];      /* "knee" */
  const char *coordinate_unit;           /* "rad" or "m" */
  const char *torque_unit;               /* "Nm" or "N" */
  const char *torque_name;               /* "torque" or "force" */
  const char *prediction[TL_MAX_JOINTS]; /* column of the predicted torque: "knee_motor_torque_Nm" */
  int place[TL_MAX_JOINTS + 1];          /* TL_PLACE_... of each joint and, last, of the base; 0: none */
  int motor;                             /* 1: a motor drives each joint through a transmission; 0: a force */
  int paper_form;                        /* 1: TL_FORM_PAPER is defined */
  int leg_bus;                           /* 1: the machine speaks the leg's CAN bus (docs/bus.md) */
  tl_channel_set channels;
  tl_sensors sensors;
  tl_plant_bench bench;
} tl_facts;

/* Of an unknown plant: no joints, no name. */
const tl_facts *tl_plant_facts(tl_plant plant);
/* The plant of a name. TL_ERR_ARGUMENT for an unknown one. */
TL_CHECK tl_status tl_plant_find(const char *name, tl_plant *plant);
/* The channels of a plant. TL_ERR_ARGUMENT for an unknown plant or set NULL. */
TL_CHECK tl_status tl_channel_set_of(tl_plant plant, tl_channel_set *set);

/* A number or a transmission that a plant's model file holds. */
typedef enum tl_key_kind {
  TL_KEY_ANY = 0,      /* a finite number */
  TL_KEY_POSITIVE,     /* above 0 */
  TL_KEY_NOT_NEGATIVE, /* 0 or above */
  TL_KEY_TRANSMISSION  /* a tl_transmission */
} tl_key_kind;
typedef struct tl_key {
  const char *name; /* with its sections: "knee.friction.coulomb_Nm" */
  size_t offset;    /* of its double or tl_transmission in tl_model */
  tl_key_kind kind;
  int optional; /* 1: may be left out, then 0 */
} tl_key;

/* Keys of a plant's model file in its order, those of one section together; n of them. */
const tl_key *tl_model_keys(tl_plant plant, int *n);

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
/* ---- one joint's drive --------------------------------------------------- */

/* Joint torque per recorded torque at q: the drive's ratio where the torque is the motor's, 1 where it is the
 * joint's. */
double tl_torque_ratio(const tl_model *m, int joint, double q);
/* The motor's torque at a recorded one, where the motor turns `ratio` times as fast as the joint. */
double tl_motor_torque(const tl_model *m, double torque, double ratio);
/* Torque as recorded per current at q [N m / A]; 1 where no current but the force itself is recorded. */
double tl_torque_per_current(const tl_model *m, int joint, double q);
/* The drive's angle that is recorded at q, the motor's or the joint's, and its rate per rate of q. */
double tl_drive_position(const tl_model *m, int joint, double q);
double tl_drive_ratio(const tl_model *m, int joint, double q);
/* Angle of the joint's motor at q, and its rate per rate of q: q and 1 where there is no transmission. */
double tl_motor_angle(const tl_model *m, int joint, double q);
double tl_motor_ratio(const tl_model *m, int joint, double q);

/* Constant part of a joint's torque [N m] or [N]: 0 where the plant has none. */
double tl_joint_offset(const tl_model *m, int joint);
/* The model without constant torques. */
void tl_clear_offsets(tl_model *m);
/* Inertia that turns with a joint's motor, in the joint's coordinate, and in *torque what its changing ratio
 * takes: of the rotor where the model has one, else `share` of the joint's own inertia. */
double tl_motor_inertia(const tl_model *m, int joint, double share, const tl_motion *motion, double *torque);
/* Takes it out of the model, whose torque at the joint then is the joint's: no rotor, ratio 1. */
void tl_take_motor(tl_model *m, int joint, double share);
/* Joint torque that accelerates the rotor of a joint's motor; where the model has none of its own, the joint's inertia, which
 * holds it. */
double tl_rotor_torque(const tl_model *m, const tl_motion *motion, int joint);

/* Does gravity act? Not on a slider, nor on a pendulum whose moment is 0. */
int tl_has_gravity(const tl_model *m);
/* Angle of joint 0 at which the plant hangs straight down [rad]. */
double tl_gravity_zero(const tl_model *m);
/* Joint torque per tilt of the base about the joints' axes [N m / rad], for every joint. */
void tl_gravity_tilt(const tl_model *m, const double q[TL_MAX_JOINTS], double joint_torque[TL_MAX_JOINTS]);

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

/* The leg's base parameters, by number. */
enum {
  TL_LEG_SHANK_INERTIA, /* I1 + ms ds^2 + mm dma^2 */
  TL_LEG_SHANK_MOMENT,  /* ms ds + mm dma */
  TL_LEG_FOOT_MOMENT,   /* mf df */
  TL_LEG_FOOT_INERTIA,  /* If + mf df^2 */
  TL_LEG_ROTOR_INERTIA, /* of the ankle's motor */
  TL_LEG_KNEE_COULOMB,
  TL_LEG_KNEE_VISCOUS,
  TL_LEG_ANKLE_COULOMB,
  TL_LEG_ANKLE_VISCOUS,
  TL_LEG_BASES
};

/* Base (linear) parameters: number, name, and value at the model's physical ones.
 *   leg       TL_LEG_...: shank_inertia, shank_moment, foot_moment, foot_inertia, ankle_rotor_inertia,
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

/* ---- many instants at once ----------------------------------------------- */

/* Where a motion stands: for each joint of the plant arrays of n <= TL_BLOCK_ROWS. With 64 instants the rows
 * take 10 KiB: for the stack of a controller. */
#define TL_BLOCK_ROWS 64
typedef struct tl_motion_block {
  const double *q[TL_MAX_JOINTS], *v[TL_MAX_JOINTS], *a[TL_MAX_JOINTS], *slip[TL_MAX_JOINTS];
} tl_motion_block;
/* Their regressor, column after column, with room for the target behind a joint's last column. */
typedef struct tl_regressor_block {
  double column[TL_MAX_JOINTS][TL_MAX_ROW + 1][TL_BLOCK_ROWS];
  double known[TL_MAX_JOINTS][TL_BLOCK_ROWS];
} tl_regressor_block;

/* slip of n instants as tl_slip_from_velocity says, (n) for each joint of the plant */
void tl_slip_block(const tl_model *m, const double *const v[TL_MAX_JOINTS], size_t n,
                   double slip[TL_MAX_JOINTS][TL_BLOCK_ROWS]);
/* The rows of n instants, the same bits as tl_regressor's; columns that a joint does not have are undefined. */
void tl_regressor_rows(const tl_model *m, const tl_motion_block *motion, size_t n, tl_regressor_block *rows);

#ifdef __cplusplus
}
#endif
#endif
