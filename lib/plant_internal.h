/* plant_internal.h: one plant's row in the table of plants, private to lib/plant*.c. */
#ifndef TALUS_PLANT_INTERNAL_H
#define TALUS_PLANT_INTERNAL_H

#include <math.h>
#include <stddef.h>

#include "talus/plant.h"

/* Everything that is asked about a plant. Where it says Nullable, plant.c or plant_model.c has what most plants do. */
typedef struct tl_plant_table {
  tl_facts facts;

  /* model file, and what of it is identified */
  const tl_key *key;
  int keys;
  const tl_parameter *parameter;
  int parameters;
  const char *const *base;
  int bases;
  void (*base_at)(const tl_model *m, const double *p, double *base);
  void (*base_jacobian)(const tl_model *m, double *jacobian); /* into zeros */

  /* dynamics, as the functions of plant.h say; torques as recorded */
  void (*inverse)(const tl_model *m, const tl_motion *motion, double torque[TL_MAX_JOINTS]);
  /* Nullable: of one joint, by its inertia */
  tl_status (*forward)(const tl_model *m, const double torque[TL_MAX_JOINTS], tl_motion *motion);
  void (*inertia_matrix)(const tl_model *m, const double q[TL_MAX_JOINTS], double *matrix);
  /* Nullable: 0 */
  double (*potential)(const tl_model *m, const double q[TL_MAX_JOINTS]);
  /* Nullable: gravity does nothing; tl_tilt_by_turning does for joints that turn about the tilt's axis */
  void (*tilt)(const tl_model *m, const double q[TL_MAX_JOINTS], double joint_torque[TL_MAX_JOINTS]);
  /* Nullable: the torques are the joints' */
  void (*ratios)(const tl_model *m, const double q[TL_MAX_JOINTS], double ratio[TL_MAX_JOINTS]);
  /* the rows, densely in the order of tl_row_index, and what is known, into zeros */
  void (*regressor)(const tl_model *m, const tl_motion *motion, double *row, double known[TL_MAX_JOINTS]);
  /* Nullable: one instant after the other */
  void (*rows)(const tl_model *restrict m, const tl_motion_block *restrict motion, size_t n,
               tl_regressor_block *restrict rows);
  /* Nullable: every base parameter in its order */
  int (*row_index)(const tl_model *m, int joint, int *index);

  /* places of numbers in tl_model, 0 where there is none */
  size_t offset[TL_MAX_JOINTS];  /* constant torque */
  size_t inertia[TL_MAX_JOINTS]; /* a joint's own, of which its motor is a share */
  size_t gravity_moment;         /* 0 there: no gravity */
  size_t gravity_zero;
  int rotor[TL_MAX_JOINTS]; /* 1: rotor_inertia_kg_m2 of the drive counts */
} tl_plant_table;

/* tl_plant_leg, tl_plant_pendulum, ...: one for each row of TL_PLANTS */
#define TL_PLANT_DECLARATION(upper, lower) extern const tl_plant_table tl_plant_##lower;
TL_PLANTS(TL_PLANT_DECLARATION)

/* every row, and last that of an unknown plant: no joints, an inverse that does nothing, no other functions */
extern const tl_plant_table *const tl_plant_rows[TL_PLANT_COUNT + 1];
static inline const tl_plant_table *tl_plant_table_of(tl_plant plant) {
  unsigned row = (unsigned)plant;

  return tl_plant_rows[row < TL_PLANT_COUNT ? row : TL_PLANT_COUNT];
}

/* tilt of a plant whose absolute angles it turns: gravity's lever arms turned by a right angle */
void tl_tilt_by_turning(const tl_model *m, const double q[TL_MAX_JOINTS], double joint_torque[TL_MAX_JOINTS]);

/* no lower bound */
#define TL_UNBOUNDED (-HUGE_VAL)

/* place of a drive's number in tl_model */
#define TL_DRIVE_OFFSET(joint, field)                                                                        \
  (offsetof(tl_model, drive) + (size_t)(joint) * sizeof(tl_drive) + offsetof(tl_drive, field))

/* keys of a rotary drive's section without its end: a rotor, or nothing, and TL_FRICTION_KEYS follow */
#define TL_DRIVE_KEYS(section, joint)                                                                        \
  {section ".transmission", TL_DRIVE_OFFSET(joint, transmission), TL_KEY_TRANSMISSION, 0}, {                 \
    section ".torque_constant_Nm_A", TL_DRIVE_OFFSET(joint, torque_constant_Nm_A), TL_KEY_POSITIVE, 0        \
  }
#define TL_FRICTION_KEYS(section, joint)                                                                     \
  {section ".friction.coulomb_Nm", TL_DRIVE_OFFSET(joint, coulomb_Nm), TL_KEY_NOT_NEGATIVE, 0}, {            \
    section ".friction.viscous_Nms_rad", TL_DRIVE_OFFSET(joint, viscous_Nms_rad), TL_KEY_NOT_NEGATIVE, 0     \
  }

/* no sensor at either joint */
#define TL_NO_CHANNELS                                                                                       \
  { TL_NO_CHANNEL, TL_NO_CHANNEL }

#endif
