/* elasticity.c: a transmission that twists in proportion to the load (Spong 1987) */
#include "../effect_columns.h"

enum { SHARE, COMPLIANCE, FRICTION_COMPLIANCE, STRENGTHS };
enum { STIFFNESS, DAMPING, FRICTION_SHARE, VISCOUS_SHARE, MOTOR_SHARE, SOFT, SOFT_SHARE, HARDENING, SHAPES };

static void change(const double *value, tl_effect_change *to) {
  const double *shape = value + STRENGTHS;
  double compliance = value[SHARE] / shape[STIFFNESS] + value[COMPLIANCE];

  if (!(compliance > 0.0)) return;
  to->compliance_rad_Nm += compliance;
  tl_effect_larger(&to->damping_s, shape[DAMPING]);
  tl_effect_larger(&to->friction_share, shape[FRICTION_SHARE]);
  tl_effect_larger(&to->viscous_share, shape[VISCOUS_SHARE]);
  tl_effect_larger(&to->motor_share, shape[MOTOR_SHARE]);
  to->soft_rad = shape[SOFT];
  to->soft_loss = 1.0 - shape[SOFT_SHARE];
  to->hardening_Nm_rad3 = shape[HARDENING];
}

/* the joint stands behind its motor by minus a torque, per unit of compliance */
static void twist(tl_effect_prepared *p, int joint, int strength, const tl_effect_wanted *wanted) {
  const tl_effect_segment *s = p->segment;
  double *shift[3] = {p->work, p->work + s->n, p->work + 2 * s->n};
  const double *load = tl_columns_load(p, joint);
  const tl_drive *d = &s->model->drive[joint];
  size_t i;

  for (i = 0; i < s->n; i++)
    shift[0][i] = strength == FRICTION_COMPLIANCE
                      ? d->coulomb_Nm * s->slip[joint][i] + d->viscous_Nms_rad * s->v[joint][i]
                      : load[i];
  tl_columns_bridge(s, joint, shift[0]);
  for (i = 0; i < s->n; i++) shift[0][i] = -shift[0][i];
  tl_columns_rates(s, shift);
  tl_columns_displaced(p, joint, shift, strength, wanted);
}

/* the joint swings on its spring against its motor, under the load of the motor's motion */
static void link(const double *shape, tl_flexible_joint *to) {
  to->stiffness_Nm_rad = shape[STIFFNESS];
  to->damping_s = shape[DAMPING];
  to->friction_share = shape[FRICTION_SHARE];
  to->viscous_share = shape[VISCOUS_SHARE];
  to->motor_share = shape[MOTOR_SHARE];
  to->soft_rad = shape[SOFT];
  to->soft_share = shape[SOFT_SHARE];
  to->hardening_Nm_rad3 = shape[HARDENING];
}

/* where the spring is stiff, it follows load and friction at once */
static void columns(tl_effect_prepared *p, int joint, const double *shape, const tl_effect_wanted *wanted) {
  int k;

  (void)shape;
  for (k = COMPLIANCE; k <= FRICTION_COMPLIANCE; k++)
    if (tl_columns_wants(wanted, 1u << k)) twist(p, joint, k, wanted);
}

const tl_effect_kind tl_effect_elasticity = {
    .name = "elasticity",
    .order = 200,
    .meaning = "torsional compliance between motor and joint",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_CHANGE,
    .once = 1,
    .strengths = STRENGTHS,
    .shapes = SHAPES,
    .parameter =
        {/* of the twist; 1 for what the stiffness says */
         [SHARE] = {"share", 0.0, 2.0, 1.0, 0, 0.0},
         /* of a stiff spring */
         [COMPLIANCE] = {"compliance_rad_Nm", 0.0, 0.05, 0.0, TL_DEFAULT(0.0)},
         [FRICTION_COMPLIANCE] = {"friction_compliance_rad_Nm", 0.0, 0.05, 0.0, TL_FIT_ONLY(0.0)},
         [STRENGTHS + STIFFNESS] = {"stiffness_Nm_rad", 0.1, 1e8, 1000.0, 0, 0.0},
         [STRENGTHS + DAMPING] = {"damping_s", 0.0, 2.0, 0.001, 0, 0.0},
         /* beyond the spring, of the dry friction */
         [STRENGTHS + FRICTION_SHARE] = {"friction_share", 0.0, 1.0, 0.0, TL_DEFAULT(0.0)},
         [STRENGTHS + VISCOUS_SHARE] = {"viscous_share", 0.0, 1.0, 0.0, TL_DEFAULT(0.0)},
         [STRENGTHS + MOTOR_SHARE] = {"motor_share", 0.02, 0.9, TL_EFFECT_MOTOR_SHARE,
                                      TL_DEFAULT(TL_EFFECT_MOTOR_SHARE)},
         /* so far a share of the stiffness */
         [STRENGTHS + SOFT] = {"soft_rad", 0.0, 0.1, 0.0, TL_DEFAULT(0.0)},
         [STRENGTHS + SOFT_SHARE] = {"soft_share", 0.0, 1.0, 1.0, TL_DEFAULT(1.0)},
         [STRENGTHS + HARDENING] = {"hardening_Nm_rad3", 0.0, 1e10, 0.0, TL_DEFAULT(0.0)}},
    .change = change,
    .columns = columns,
    .link = link,
    .memory_s = 2.0,
};
