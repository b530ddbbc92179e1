/* backlash.c: lost motion between motor and joint: a dead zone before the teeth meet */
#include "../effect_columns.h"

enum { SHARE, STRENGTHS };
enum { GAP, STIFFNESS, DAMPING, FRICTION_SHARE, VISCOUS_SHARE, MOTOR_SHARE, DRAG, OFFSET_SHARE, SHAPES };

#define DAMPING_S 1e-3 /* of the teeth in contact: their damping over their stiffness */

static void change(const double *value, tl_effect_change *to) {
  const double *shape = value + STRENGTHS;

  if (!(value[SHARE] * shape[GAP] > 0.0)) return;
  to->gap_rad += value[SHARE] * shape[GAP];
  to->compliance_rad_Nm += 1.0 / shape[STIFFNESS];
  tl_effect_larger(&to->damping_s, shape[DAMPING]);
  tl_effect_larger(&to->friction_share, shape[FRICTION_SHARE]);
  tl_effect_larger(&to->viscous_share, shape[VISCOUS_SHARE]);
  tl_effect_larger(&to->motor_share, shape[MOTOR_SHARE]);
  to->drag_Nm += shape[DRAG];
  tl_effect_larger(&to->offset_share, shape[OFFSET_SHARE]);
}

/* the joint swings between the teeth under the load of its motor's motion, half the gap to each side */
static void link(const double *shape, tl_flexible_joint *to) {
  to->stiffness_Nm_rad = shape[STIFFNESS];
  to->gap_rad = shape[GAP];
  to->damping_s = shape[DAMPING];
  to->friction_share = shape[FRICTION_SHARE];
  to->viscous_share = shape[VISCOUS_SHARE];
  to->motor_share = shape[MOTOR_SHARE];
  to->soft_share = 1.0;
  to->drag_Nm = shape[DRAG];
  to->offset_share = shape[OFFSET_SHARE];
}

const tl_effect_kind tl_effect_backlash = {
    .name = "backlash",
    .order = 210,
    .meaning = "lost motion between motor and joint when the torque reverses",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_CHANGE,
    .once = 1,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter =
        {/* of the lost motion; 1 for what the gap says */
         [SHARE] = {"share", 0.0, 2.0, 1.0, 0, 0.0},
         [STRENGTHS + GAP] = {"gap_rad", 1e-4, 0.1, 0.004, 0, 0.0},
         [STRENGTHS + STIFFNESS] = {"stiffness_Nm_rad", 0.1, 1e8, 3000.0, 0, 0.0},
         [STRENGTHS + DAMPING] = {"damping_s", 0.0, 2.0, DAMPING_S, TL_DEFAULT(DAMPING_S)},
         /* beyond the gap, of the dry friction */
         [STRENGTHS + FRICTION_SHARE] = {"friction_share", 0.0, 1.0, 0.0, TL_DEFAULT(0.0)},
         [STRENGTHS + VISCOUS_SHARE] = {"viscous_share", 0.0, 1.0, 0.0, TL_DEFAULT(0.0)},
         [STRENGTHS + MOTOR_SHARE] = {"motor_share", 0.02, 0.9, TL_EFFECT_MOTOR_SHARE,
                                      TL_DEFAULT(TL_EFFECT_MOTOR_SHARE)},
         /* friction between motor and joint in the gap */
         [STRENGTHS + DRAG] = {"drag_Nm", 0.0, 100.0, 0.0, TL_DEFAULT(0.0)},
         /* of the joint's constant torque: it presses the joint to one face, or its motor */
         [STRENGTHS + OFFSET_SHARE] = {"offset_share", 0.0, 1.0, 0.0, TL_DEFAULT(0.0)}},
    .change = change,
    .link = link,
    .memory_s = 2.0,
};
