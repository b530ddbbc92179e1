/* plant_internal.h: what plant.c asks of each plant, inside lib/. */
#ifndef TALUS_PLANT_INTERNAL_H
#define TALUS_PLANT_INTERNAL_H

#include <math.h>
#include <stddef.h>

#include "talus/plant.h"

/* inverse dynamics of one plant: torque as recorded */
void tl_leg_inverse(const tl_model *m, const tl_motion *motion, double torque[TL_MAX_JOINTS]);
void tl_pendulum_inverse(const tl_model *m, const tl_motion *motion, double torque[TL_MAX_JOINTS]);
void tl_slider_inverse(const tl_model *m, const tl_motion *motion, double torque[TL_MAX_JOINTS]);

tl_status tl_leg_forward(const tl_model *m, const double torque[TL_MAX_JOINTS], tl_motion *motion);
void tl_leg_inertia_matrix(const tl_model *m, const double q[TL_MAX_JOINTS], double matrix[4]);
void tl_leg_ratios(const tl_model *m, const double q[TL_MAX_JOINTS], double ratio[TL_MAX_JOINTS]);

/* potential energy [J]; kinetic energy follows from the inertia matrix */
double tl_leg_potential(const tl_model *m, const double q[TL_MAX_JOINTS]);
double tl_pendulum_potential(const tl_model *m, const double q[TL_MAX_JOINTS]);

/* the rows' factors, densely in the order of the plant's tl_row_index, and what is known */
void tl_leg_regressor(const tl_model *m, const tl_motion *motion, double *row, double known[TL_MAX_JOINTS]);
void tl_pendulum_regressor(const tl_model *m, const tl_motion *motion, double *row);
void tl_slider_regressor(const tl_motion *motion, double *row);

/* Many instants at once: where a motion stands, and its rows, column after column, with room for
 * the target behind a joint's last column. With 64 instants the rows take 10 KiB: for the stack of
 * a controller. */
#define TL_PIECE 64
typedef struct tl_piece {
  const double *q[TL_MAX_JOINTS], *v[TL_MAX_JOINTS], *a[TL_MAX_JOINTS], *slip[TL_MAX_JOINTS];
} tl_piece;
typedef struct tl_piece_rows {
  double column[TL_MAX_JOINTS][TL_MAX_ROW + 1][TL_PIECE];
  double known[TL_MAX_JOINTS][TL_PIECE];
} tl_piece_rows;

/* slip of n instants as tl_slip_from_velocity says, (n) for each joint of the plant */
void tl_piece_slip(const tl_model *m, const double *const v[TL_MAX_JOINTS], size_t n,
                   double slip[TL_MAX_JOINTS][TL_PIECE]);
/* rows of n <= TL_PIECE instants, the same bits as tl_leg_regressor's */
void tl_leg_piece(const tl_model *restrict m, const tl_piece *restrict s, size_t n,
                  tl_piece_rows *restrict rows);

/* what is identified: names, places, bounds; base values and their derivatives */
typedef struct tl_plant_table {
  const char *joint[TL_MAX_JOINTS];
  int joints;
  const tl_parameter *parameter;
  int parameters;
  const char *const *base;
  int bases;
  void (*base_at)(const tl_model *m, const double *p, double *base);
  void (*base_jacobian)(const tl_model *m, double *jacobian); /* into zeros */
} tl_plant_table;

extern const tl_plant_table tl_leg_table, tl_pendulum_table, tl_slider_table;

/* no lower bound */
#define TL_UNBOUNDED (-HUGE_VAL)

/* place of a drive's number in tl_model */
#define TL_DRIVE_OFFSET(joint, field)                                                                        \
  (offsetof(tl_model, drive) + (size_t)(joint) * sizeof(tl_drive) + offsetof(tl_drive, field))

#endif
