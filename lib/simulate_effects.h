/* simulate_effects.h: a plant's equations of motion with effects acting on it; internal to lib/. */
#ifndef TALUS_SIMULATE_EFFECTS_H
#define TALUS_SIMULATE_EFFECTS_H

#include "talus/experimental/effect.h"
#include "talus/experimental/hysteresis.h"
#include "talus/experimental/simulate.h"

#define TL_BODIES TL_LINK_BODIES /* joints, and the modes of their mount */

/* a plant and what acts on it beside its drives */
typedef struct tl_effect_dynamics {
  const tl_model *model;
  const tl_effect *effect;
  int effects, joints;
  double begin_s; /* from which effects of time count */
  /* the rest as tl_effect_dynamics_init finds it, where there are effects */
  tl_effect_change change[TL_MAX_JOINTS + 1]; /* of the joints, and of the base */
  int twists[TL_MAX_JOINTS];                  /* 1: the transmission is not rigid, but */
  tl_spring spring[TL_MAX_JOINTS];
  int needs_rotor[TL_MAX_JOINTS];        /* 1: a friction's load leaves rotor inertia out */
  int modes, moves;                      /* of the mount; 1: one of them sways or rises */
  double mount_inertia[TL_MOUNT_MODES];  /* of the mode, with the leg hanging from it */
  double mount_coupling[TL_MOUNT_MODES]; /* with the knee, the leg hanging */
  tl_model link;                         /* what lies beyond the transmissions, without friction */
  tl_model weightless;                   /* where moves: for lever arms */
} tl_effect_dynamics;

/* everything but model and effects, which stand */
void tl_effect_dynamics_init(tl_effect_dynamics *p);
/* How far a joint runs ahead of its motor where that says q, and its first and second derivative by q. */
void tl_effect_dynamics_ahead(const tl_model *m, const tl_effect_change *c, int joint, double q,
                              double ahead[3]);
/* Is there dry friction at the joint, so that it can stick? */
int tl_effect_dynamics_is_dry(const tl_effect_dynamics *p, int joint);
/* A link state that fits the motion, where it has none yet. */
void tl_effect_dynamics_begin(const tl_effect_dynamics *p, const tl_motion *motion, tl_link_state *link);
/* Dry friction at the link beyond a joint's transmission [N m]. */
double tl_effect_dynamics_link_friction(const tl_effect_dynamics *p, int joint);
/* Dry friction between a joint's motor and its link [N m]. */
double tl_effect_dynamics_drag(const tl_effect_dynamics *p, int joint);
/* Power that a joint's constant torque takes, of its motor and of a link that is not rigid with it. */
double tl_effect_dynamics_offset_W(const tl_effect_dynamics *p, int joint, const tl_motion *motion,
                                   const tl_link_state *link);
/* The speed of a joint whose link keeps to its motor: the motor's, as its ripple lets it run ahead. */
double tl_effect_dynamics_speed(const tl_effect_dynamics *p, int joint, const tl_motion *motion);
/* Accelerations and slip for given modes, as tl_forward takes torques: motion->a, motion->slip, and the
 * rates of `link`; mode[TL_CONTACTS]. A sticking joint's slip is the share of the friction's level in that direction; beyond
 * +-1 it cannot stick. *loss_W is what friction and the effects take. TL_ERR_SINGULAR as tl_forward;
 * TL_ERR_NO_CONVERGENCE where friction grows as fast as the load, so that the joint jams. */
TL_CHECK tl_status tl_effect_dynamics_accelerate(const tl_effect_dynamics *p, double t_s,
                                                 const tl_joint_mode *mode,
                                                 const double torque[TL_MAX_JOINTS], tl_motion *motion,
                                                 tl_link_state *link, double *loss_W);

#endif
