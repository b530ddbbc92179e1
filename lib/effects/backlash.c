/* backlash.c: lost motion between motor and joint: a dead zone before the teeth meet */
#include "../effect_columns.h"

#define DAMPING_S 1e-3 /* of the teeth in contact: their damping over their stiffness */

static void change(const double *value, tl_effect_change *to) {
  if (!(value[0] * value[1] > 0.0)) return;
  to->gap_rad += value[0] * value[1];
  to->compliance_rad_Nm += 1.0 / value[2];
  if (value[3] > to->damping_s) to->damping_s = value[3];
  if (value[4] > to->friction_share) to->friction_share = value[4];
  if (value[5] > to->viscous_share) to->viscous_share = value[5];
  to->motor_share = value[6];
  to->drag_Nm += value[7];
}

/* the joint swings between the teeth under the load of its motor's motion, half the gap to each side */
static void columns(tl_effect_prepared *p, int joint, const double *shape, const tl_effect_wanted *wanted) {
  tl_flexible_joint link = {shape[1], shape[0], shape[2], shape[3], shape[4],
                            shape[5], 0.0,      1.0,      0.0,      shape[6]};

  tl_columns_link(p, &link, joint, wanted);
}

const tl_effect_kind tl_effect_backlash = {
    .name = "backlash",
    .order = 210,
    .meaning = "lost motion between motor and joint when the torque reverses",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_CHANGE,
    .once = 1,
    .strengths = 1,
    .shapes = 7,
    .parameter = {{"share", 0.0, 2.0, 1.0, 0, 0.0}, /* of the lost motion; 1 for what the gap says */
                  {"gap_rad", 1e-4, 0.1, 0.004, 0, 0.0},
                  {"stiffness_Nm_rad", 0.1, 1e8, 3000.0, 0, 0.0},
                  {"damping_s", 0.0, 2.0, DAMPING_S, TL_DEFAULT(DAMPING_S)},
                  {"friction_share", 0.0, 1.0, 0.0,
                   TL_DEFAULT(0.0)}, /* beyond the gap, of the dry friction */
                  {"viscous_share", 0.0, 1.0, 0.0, TL_DEFAULT(0.0)},
                  {"motor_share", 0.02, 0.9, TL_EFFECT_MOTOR_SHARE, TL_DEFAULT(TL_EFFECT_MOTOR_SHARE)},
                  {"drag_Nm", 0.0, 100.0, 0.0,
                   TL_DEFAULT(0.0)}}, /* friction between motor and joint in the gap */
    .change = change,
    .columns = columns,
    .memory_s = 2.0,
};
