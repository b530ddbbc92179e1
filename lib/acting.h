/* acting.h: a plant's equations of motion with effects acting on it; internal to lib/. */
#ifndef TALUS_ACTING_H
#define TALUS_ACTING_H

#include "talus/effect.h"
#include "talus/simulate.h"

#define TL_BODIES (TL_MAX_JOINTS + 1) /* joints, and the base */

/* a plant and what acts on it beside its drives */
typedef struct tl_acting {
  const tl_model *model;
  const tl_effect *effect;
  int effects, joints;
  double begin_s; /* from which effects of time count */
  /* the rest as tl_acting_init finds it, where there are effects */
  tl_effect_change change[TL_BODIES];
  int twists[TL_MAX_JOINTS]; /* 1: the transmission is not rigid */
  int sways;                 /* 1: the base moves */
  double base_inertia;
  tl_model link; /* what lies beyond the transmissions, without friction */
} tl_acting;

/* everything but model and effects, which stand */
void tl_acting_init(tl_acting *p);
/* Of the mount itself, so that it resonates where it shall with the leg hanging from it; not positive where
 * it cannot. */
double tl_acting_base_inertia(const tl_model *m, const tl_effect_change *base);
/* Is there dry friction at the joint, so that it can stick? */
int tl_acting_is_dry(const tl_acting *p, int joint);
/* A state beyond that fits the motion, where it has none yet. */
void tl_acting_begin(const tl_acting *p, const tl_motion *motion, tl_beyond *beyond);
/* Accelerations and slip for given modes, as tl_forward takes torques: motion->a, motion->slip, and the
 * rates of `beyond`. A sticking joint's slip is the share of the friction's level in that direction; beyond
 * +-1 it cannot stick. *loss_W is what friction and the effects take. TL_ERR_SINGULAR as tl_forward;
 * TL_ERR_NO_CONVERGENCE where friction grows as fast as the load, so that the joint jams. */
TL_CHECK tl_status tl_acting_accelerate(const tl_acting *p, double t_s, const tl_joint_mode *mode,
                                        const double torque[TL_MAX_JOINTS], tl_motion *motion,
                                        tl_beyond *beyond, double *loss_W);

#endif
