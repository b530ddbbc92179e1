/* effect_columns.h: what kinds of effects that are no law of the instant share; internal to lib/. */
#ifndef TALUS_EFFECT_COLUMNS_H
#define TALUS_EFFECT_COLUMNS_H

#include <stddef.h>

#include "effect_kinds.h"
#include "talus/experimental/hysteresis.h"

void tl_columns_nothing(double *column, size_t n);
/* where a strength's column of a channel goes; NULL: it is not asked for */
double *tl_columns_of(const tl_effect_prepared *p, const tl_effect_wanted *wanted, int channel, int strength);
/* is one of these strengths (a set of 1 << k) asked for? */
int tl_columns_wants(const tl_effect_wanted *wanted, unsigned strengths);
/* the motion at a row */
void tl_columns_motion(const tl_effect_segment *s, size_t i, tl_motion *now);

/* What a segment's columns share, made when it is first asked for. */
/* the torque that the bare model takes at a joint, n rows */
const double *tl_columns_load(tl_effect_prepared *p, int joint);
/* slopes of a joint's bare torque by angle, speed and acceleration of another (or itself), three arrays of n rows */
double *const *tl_columns_slopes(tl_effect_prepared *p, int moved, int joint);
/* the plain model's torque as its motor's current shows it, through short stops; p->ratio[joint] is then ready, too */
const double *tl_columns_motor_torque(tl_effect_prepared *p, int joint);
/* The mount's forces and lever arms: [0], [1] force of both links' inertia to the front and upwards; [2], [3] moment
 * of the shank, [4], [5] of the foot [kg m], each times the sine and the cosine of its absolute angle. */
double *const *tl_columns_mount(tl_effect_prepared *p);

/* sin (k = 0) or cos (k = 1) of `order` times the motor's angle of a joint in shift[0], its rates in shift[1] and
 * shift[2], and the joint's ratio in shift[3] */
void tl_columns_wave(const tl_effect_prepared *p, int joint, double order, int k, double *const shift[4]);
/* does this pair of sensors see the angle between a joint and its motor? */
int tl_columns_sees(int joint, int channel);
/* What shows when a joint stands shift[0] (rates shift[1], shift[2]) ahead of where its motor says: the joint of the bare
 * model, or of the segment's with its friction and rotor. */
void tl_columns_displaced(tl_effect_prepared *p, int joint, double *const *shift, int strength,
                          const tl_effect_wanted *wanted);
void tl_columns_displaced_whole(tl_effect_prepared *p, int joint, double *const *shift, int strength,
                                const tl_effect_wanted *wanted);
/* what a joint's torque changes by when another stands shift[0] (rates shift[1], shift[2]) ahead: added to column */
void tl_columns_add_shift(tl_effect_prepared *p, int moved, double *const *shift, int joint, double *column);
/* a column of a joint's torque through its short stops */
void tl_columns_bridge(const tl_effect_segment *s, int joint, double *column);
/* rates of shift[0] in shift[1] and shift[2], by differences */
void tl_columns_rates(const tl_effect_segment *s, double *const *shift);
/* What a joint shows beyond a spring with a gap, driven by its motor's recorded motion, with no gap: elasticity. */
struct tl_flexible_joint {
  double stiffness_Nm_rad, gap_rad, damping_s;
  double friction_share,
      viscous_share;   /* of the joint's dry and viscous friction that stands beyond the spring */
  double motor_share;  /* of the joint's own inertia that turns with its motor */
  double offset_share; /* of the joint's constant torque that acts on the link */
  double soft_rad, soft_share, hardening_Nm_rad3, drag_Nm; /* as in tl_two_mass */
};
/* One of a segment, what is wanted of it, and tl_effect_link_memory(n) doubles to work in. */
typedef struct tl_columns_link {
  tl_effect_prepared *p;
  tl_flexible_joint joint;
  tl_effect_wanted wanted;
  double *work;
} tl_columns_link;
/* So many of one joint at once, TL_TWO_MASS_LANES at the most: the same to the bit as each by itself, in less time. */
void tl_columns_links(tl_columns_link *link, int links, int joint);
/* What swings on a spring under minus a load: I x'' + d x' + k x = -load. */
typedef struct tl_columns_spring {
  double inertia, stiffness, damping;
} tl_columns_spring;
/* Its free motion over nearly equal steps: exact over base_s, and a series for what a step differs from it. */
typedef struct tl_columns_swing {
  tl_columns_spring spring;
  double decay, w2;            /* of its exponential; square of its undamped frequency */
  double base_s, turned[2][2]; /* the state (x, v) after base_s of free motion */
} tl_columns_swing;
tl_columns_swing tl_columns_swing_of(tl_columns_spring spring);
/* from x, v over h while the load goes straight from one value to another */
void tl_columns_swing_on(tl_columns_swing *w, double from, double to, double h, double *x, double *v);

#endif
