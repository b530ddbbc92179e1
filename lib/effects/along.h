/* along.h: what kinds of effects that are no law of the instant share; internal to lib/. */
#ifndef TALUS_ALONG_H
#define TALUS_ALONG_H

#include <stddef.h>

#include "effects.h"
#include "link.h"

void tl_along_nothing(double *column, size_t n);
void tl_along_copy(double *column, const double *from, size_t n);
/* the motion at a row */
void tl_along_motion(const tl_effect_stretch *s, size_t i, tl_motion *now);
/* the plain model's torque at a joint [N m], friction and all */
void tl_along_plain_torque(const tl_effect_stretch *s, int joint, double *torque);
/* the torque that `link`, a model without friction, takes at a joint */
void tl_along_load(const tl_effect_stretch *s, const tl_model *link, int joint, double *load);
/* What a joint's torque (`shows`) changes by, per unit, when joint `moved` of model m moves by shift[0]
 * with the rates shift[1] and shift[2]: the slope of the inverse dynamics. */
void tl_along_shift(const tl_effect_stretch *s, const tl_model *m, int moved, double *const shift[3],
                    int shows, double *column);
/* What a joint beyond its transmission shows, from its motion against its motor (tl_along_link). */
void tl_along_twist(const tl_effect_stretch *s, const tl_model *link, int joint, double *const shift[4],
                    int shows, double *column);
/* What swings on a spring under minus a load: I x'' + d x' + k (x less what the gap leaves free) + pull x = -load. */
typedef struct tl_along_spring {
  double inertia, stiffness, damping, gap;
  double pull; /* what the load itself gains per unit of x: gravity's own spring */
} tl_along_spring;
/* from x, v over h while the load goes straight from one value to another */
void tl_along_swing(const tl_along_spring *p, double from, double to, double h, double *x, double *v);
/* The link at `joint` on its spring, driven by the recorded motion of its motor: its motion against the
 * motor's in shift[0..2], and in shift[3] the torque of the spring less what a rigid link would take. */
void tl_along_link(const tl_effect_stretch *s, const tl_model *link, int joint, double stiffness,
                   double damping_s, double gap, double *const shift[4]);

#endif
