/* elasticity.c: a transmission that twists in proportion to the load (Spong 1987) */
#include "../effect_columns.h"

static void change(const double *value, tl_effect_change *to) {
  double compliance = value[0] / value[3] + value[1];

  if (!(compliance > 0.0)) return;
  to->compliance_rad_Nm += compliance;
  if (value[4] > to->damping_s) to->damping_s = value[4];
  to->friction_share = value[5];
  to->viscous_share = value[6];
  to->motor_share = value[7];
  to->soft_rad = value[8];
  to->soft_loss = 1.0 - value[9];
  to->hardening_Nm_rad3 = value[10];
}

/* the joint stands behind its motor by minus a torque, per unit of compliance */
static void twist(tl_effect_prepared *p, int joint, int by_friction, const tl_effect_wanted *wanted) {
  const tl_effect_segment *s = p->segment;
  double *shift[3] = {p->work, p->work + s->n, p->work + 2 * s->n};
  const double *load = tl_columns_load(p, joint);
  const tl_drive *d = &s->model->drive[joint];
  size_t i;

  for (i = 0; i < s->n; i++)
    shift[0][i] =
        by_friction ? d->coulomb_Nm * s->slip[joint][i] + d->viscous_Nms_rad * s->v[joint][i] : load[i];
  tl_columns_bridge(s, joint, shift[0]);
  for (i = 0; i < s->n; i++) shift[0][i] = -shift[0][i];
  tl_columns_rates(s, shift);
  tl_columns_displaced(p, joint, shift, 1 + by_friction, wanted);
}

/* The joint swings on its spring against its motor, under the load of the motor's motion; or, where the spring
 * is stiff, it follows load and friction at once. */
static void columns(tl_effect_prepared *p, int joint, const double *shape, const tl_effect_wanted *wanted) {
  tl_flexible_joint link = {shape[0], 0.0,      shape[1], shape[2], shape[3],
                            shape[4], shape[5], shape[6], shape[7], 0.0};
  int k;

  if (tl_columns_wants(wanted, 1u)) tl_columns_link(p, &link, joint, wanted);
  for (k = 0; k < 2; k++)
    if (tl_columns_wants(wanted, 2u << k)) twist(p, joint, k, wanted);
}

const tl_effect_kind tl_effect_elasticity = {
    .name = "elasticity",
    .order = 200,
    .meaning = "torsional compliance between motor and joint",
    .places = TL_EFFECT_AT_JOINTS,
    .acts = TL_EFFECT_CHANGE,
    .once = 1,
    .strengths = 3,
    .shapes = 8,
    .parameter = {{"share", 0.0, 2.0, 1.0, 0, 0.0}, /* of the twist; 1 for what the stiffness says */
                  {"compliance_rad_Nm", 0.0, 0.05, 0.0, TL_DEFAULT(0.0)}, /* of a stiff spring */
                  {"friction_compliance_rad_Nm", 0.0, 0.05, 0.0, TL_FIT_ONLY(0.0)},
                  {"stiffness_Nm_rad", 0.1, 1e8, 1000.0, 0, 0.0},
                  {"damping_s", 0.0, 2.0, 0.001, 0, 0.0},
                  {"friction_share", 0.0, 1.0, 0.0,
                   TL_DEFAULT(0.0)}, /* beyond the spring, of the dry friction */
                  {"viscous_share", 0.0, 1.0, 0.0, TL_DEFAULT(0.0)},
                  {"motor_share", 0.02, 0.9, TL_EFFECT_MOTOR_SHARE, TL_DEFAULT(TL_EFFECT_MOTOR_SHARE)},
                  {"soft_rad", 0.0, 0.1, 0.0, TL_DEFAULT(0.0)}, /* so far a share of the stiffness */
                  {"soft_share", 0.0, 1.0, 1.0, TL_DEFAULT(1.0)},
                  {"hardening_Nm_rad3", 0.0, 1e10, 0.0, TL_DEFAULT(0.0)}},
    .change = change,
    .columns = columns,
    .memory_s = 2.0,
};
