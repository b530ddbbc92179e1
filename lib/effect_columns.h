/* effect_columns.h: what kinds of effects that are no law of the instant share; internal to lib/. */
#ifndef TALUS_EFFECT_COLUMNS_H
#define TALUS_EFFECT_COLUMNS_H

#include <stddef.h>

#include "effect_kinds.h"
#include "effect_link.h"

void tl_columns_nothing(double *column, size_t n);
void tl_columns_copy(double *column, const double *from, size_t n);
/* the motion at a row */
void tl_columns_motion(const tl_effect_stretch *s, size_t i, tl_motion *now);
/* the plain model's torque at a joint [N m], friction and all */
void tl_columns_plain_torque(const tl_effect_stretch *s, int joint, double *torque);
/* the torque that `link`, a model without friction, takes at a joint */
void tl_columns_load(const tl_effect_stretch *s, const tl_model *link, int joint, double *load);
/* What a joint's torque (`shows`) changes by, per unit, when joint `moved` of model m moves by shift[0]
 * with the rates shift[1] and shift[2]: the slope of the inverse dynamics. */
void tl_columns_shift(const tl_effect_stretch *s, const tl_model *m, int moved, double *const *shift,
                      int shows, double *column);
/* sin (k = 0) or cos (k = 1) of `order` times the motor's angle of a joint in shift[0], its rates in shift[1] and
 * shift[2], and the joint's ratio in shift[3] */
void tl_columns_wave(const tl_effect_stretch *s, int joint, double order, int k, double *const shift[4]);
/* does this pair of sensors see the angle between a joint and its motor? */
int tl_columns_sees(int joint, int shows);
/* What shows when the joint of `link` stands shift[0] (rates shift[1], shift[2]) ahead of where its motor says. */
void tl_columns_displaced(const tl_effect_stretch *s, const tl_model *link, int joint, double *const *shift,
                          int shows, double *column);
/* a column of a joint's torque through its short stops */
void tl_columns_bridge(const tl_effect_stretch *s, int joint, double *column);
/* rates of shift[0] in shift[1] and shift[2], by differences */
void tl_columns_rates(const tl_effect_stretch *s, double *const *shift);
/* What a joint shows beyond a spring with a gap, driven by its motor's recorded motion, with no gap: elasticity. */
typedef struct tl_flexible_joint {
  double stiffness_Nm_rad, gap_rad, damping_s;
  double friction_share,
      viscous_share;  /* of the joint's dry and viscous friction that stands beyond the spring */
  double motor_share; /* of the joint's own inertia that turns with its motor */
  double soft_rad, soft_share, hardening_Nm_rad3, drag_Nm; /* as in tl_two_mass */
} tl_flexible_joint;
void tl_columns_link(const tl_effect_stretch *s, const tl_flexible_joint *p, int joint, int shows,
                     double *column);
/* What swings on a spring under minus a load: I x'' + d x' + k x = -load. */
typedef struct tl_columns_spring {
  double inertia, stiffness, damping;
} tl_columns_spring;
/* from x, v over h while the load goes straight from one value to another */
void tl_columns_swing(const tl_columns_spring *p, double from, double to, double h, double *x, double *v);

#endif
