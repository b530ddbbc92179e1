/* effect_flexible_joint.c: what a joint shows beyond a spring and a gap; see along.h. */
#include "effect_columns.h"

#include <string.h>

#include "talus/experimental/hysteresis.h"

static double mean_step_s(const tl_effect_stretch *s) {
  return s->n > 1 ? (s->t_s[s->n - 1] - s->t_s[0]) / (double)(s->n - 1) : 1.0;
}

/* the link with the leg straight: it changes little with the pose, and what it changes by is not its own swing */
static tl_two_mass link_of(const tl_effect_stretch *s, const tl_model *bare, const tl_flexible_joint *p,
                           int joint) {
  static const double straight[TL_MAX_JOINTS] = {0.0, 0.0};
  double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS] = {0.0};
  tl_two_mass link;

  memset(&link, 0, sizeof link);
  tl_inertia_matrix(bare, straight, matrix);
  link.inertia_kg_m2 = matrix[joint * tl_joint_count(bare) + joint];
  link.stiffness_Nm_rad = p->stiffness_Nm_rad;
  link.gap_rad = p->gap_rad;
  link.soft_rad = p->soft_rad;
  link.soft_share = p->soft_share;
  link.hardening_Nm_rad3 = p->hardening_Nm_rad3;
  link.drag_Nm = p->drag_Nm;
  link.damping_s = p->damping_s;
  link.friction_share = p->friction_share;
  link.viscous_share = p->viscous_share;
  link.coulomb_Nm = s->model->drive[joint].coulomb_Nm;
  link.viscous_Nms_rad = s->model->drive[joint].viscous_Nms_rad;
  link.settle_s = TL_TWO_MASS_SETTLE_S;
  link.step_s = mean_step_s(s);
  return link;
}

/* the torque of a rigid link, from its load, and its share of the friction */
static double rigid_torque(const tl_effect_stretch *s, const tl_flexible_joint *p, int joint, double load,
                           size_t i) {
  const tl_drive *d = &s->model->drive[joint];

  return load + p->friction_share * d->coulomb_Nm * s->slip[joint][i] +
         p->viscous_share * d->viscous_Nms_rad * s->v[joint][i];
}

void tl_columns_link(const tl_effect_stretch *s, const tl_flexible_joint *p, int joint, int shows,
                     double *column) {
  double *shift[3] = {s->work, s->work + s->n, s->work + 2 * s->n}, *other = shift[1],
         *load = s->work + 3 * s->n;
  tl_two_mass_motion motion = {shift[0], shift[2], column};
  tl_model bare = tl_effect_bare_model(s->model);
  tl_two_mass link;
  size_t i;

  tl_columns_nothing(column, s->n);
  if (s->n == 0 || (shows >= TL_MAX_JOINTS && !tl_columns_sees(joint, shows))) return;
  tl_take_motor(&bare, joint, p->motor_share);
  link = link_of(s, &bare, p, joint);
  tl_columns_load(s, &bare, joint, load);
  for (i = 0; i < s->n; i++) other[i] = load[i] - link.inertia_kg_m2 * s->a[joint][i];
  tl_two_mass_along(&link, s->t_s, s->q[joint], s->v[joint], other, s->n, &motion);
  if (shows >= TL_MAX_JOINTS) {
    tl_columns_copy(column, shift[0], s->n);
  } else if (shows == joint) {
    for (i = 0; i < s->n; i++) column[i] = shift[2][i] - rigid_torque(s, p, joint, load[i], i);
  } else {
    tl_columns_rates(s, shift);
    for (i = 0; i < s->n; i++) shift[2][i] = column[i] - s->a[joint][i];
    tl_columns_shift(s, &bare, joint, shift, shows, column);
  }
}
