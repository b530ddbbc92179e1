/* effect_flexible_joint.c: what a joint shows beyond a spring and a gap; see effect_columns.h. */
#include "effect_columns.h"

#include <math.h>
#include <string.h>

#include "math_inline.h"

#define LEAST_SHARE                                                                                          \
  0.05 /* of a joint's inertia that stays with its link, whatever a fit says of its motor's part */

static double mean_step_s(const tl_effect_segment *s) {
  return s->n > 1 ? (s->t_s[s->n - 1] - s->t_s[0]) / (double)(s->n - 1) : 1.0;
}

static double straight_inertia(const tl_model *m, int joint) {
  static const double straight[TL_MAX_JOINTS] = {0.0, 0.0};
  double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS] = {0.0};

  tl_inertia_matrix(m, straight, matrix);
  return matrix[tl_entry(tl_joint_count(m), joint, joint)];
}

/* With the leg straight. What of the joint's inertia turns with its motor goes to *turning. */
static double link_inertia(const tl_effect_prepared *p, int joint, double motor_share, double *turning) {
  double whole = straight_inertia(&p->bare, joint);
  tl_model beyond = p->bare;

  tl_take_motor(&beyond, joint, motor_share);
  *turning = whole - straight_inertia(&beyond, joint);
  if (p->segment->link_inertia_kg_m2[joint] > 0.0) whole = p->segment->link_inertia_kg_m2[joint];
  return whole - *turning > LEAST_SHARE * whole ? whole - *turning : LEAST_SHARE * whole;
}

double tl_effect_link_rad_s(const tl_effect_prepared *p, int joint, double motor_share,
                            double stiffness_Nm_rad) {
  double turning;

  return sqrt(stiffness_Nm_rad / link_inertia(p, joint, motor_share, &turning));
}

static tl_two_mass link_of(const tl_effect_prepared *p, const tl_flexible_joint *f, int joint,
                           double *turning) {
  const tl_effect_segment *s = p->segment;
  tl_two_mass link;

  memset(&link, 0, sizeof link);
  link.inertia_kg_m2 = link_inertia(p, joint, f->motor_share, turning);
  link.stiffness_Nm_rad = f->stiffness_Nm_rad;
  link.gap_rad = f->gap_rad;
  link.soft_rad = f->soft_rad;
  link.soft_share = f->soft_share;
  link.hardening_Nm_rad3 = f->hardening_Nm_rad3;
  link.drag_Nm = f->drag_Nm;
  link.damping_s = f->damping_s;
  link.friction_share = f->friction_share;
  link.viscous_share = f->viscous_share;
  link.coulomb_Nm = s->model->drive[joint].coulomb_Nm;
  link.viscous_Nms_rad = s->model->drive[joint].viscous_Nms_rad;
  link.settle_s = TL_TWO_MASS_SETTLE_S;
  link.step_s = mean_step_s(s);
  return link;
}

/* Row by row: the link's inertia in its pose, by how much its load grows as it runs ahead of its motor, and what the other
 * joint's acceleration adds between two rows beside that of its ends, as its speeds tell. The first and the last in row[2 n]. */
static void set_rows(tl_effect_prepared *p, int joint, double *row, tl_two_mass *link) {
  const tl_effect_segment *s = p->segment;
  double *const *own = tl_columns_slopes(p, joint, joint), *inertia = row, *bulge = row + s->n;
  double apart = link->inertia_kg_m2 - straight_inertia(&p->bare, joint); /* less what turns, and as given */
  int other = 1 - joint, coupled = tl_joint_count(s->model) > 1;
  const double *by = coupled ? tl_columns_slopes(p, other, joint)[2] : NULL, *v = s->v[other],
               *a = s->a[other];
  size_t i;

  for (i = 0; i < s->n; i++) {
    inertia[i] = own[2][i] + apart > LEAST_SHARE * link->inertia_kg_m2 ? own[2][i] + apart
                                                                       : LEAST_SHARE * link->inertia_kg_m2;
    bulge[i] = 0.0;
    if (coupled && i + 1 < s->n)
      bulge[i] = by[i] * ((v[i + 1] - v[i]) / (s->t_s[i + 1] - s->t_s[i]) - 0.5 * (a[i] + a[i + 1]));
  }
  link->row_inertia_kg_m2 = inertia;
  link->row_stiffness_Nm_rad = own[0];
  link->row_damping_Nms_rad = own[1];
  link->row_bulge_Nm = bulge;
}

/* what of the joint's constant torque acts on the link */
static double offset_of(const tl_effect_segment *s, const tl_flexible_joint *f, int joint) {
  return f->offset_share * tl_joint_offset(s->model, joint);
}

/* the spring's torque less that of a rigid link: its load, and its share of the friction */
static void add_own_torque(const tl_effect_prepared *p, const tl_flexible_joint *f, int joint, double turning,
                           const double *torque, double *column) {
  const tl_effect_segment *s = p->segment;
  const tl_drive *d = &s->model->drive[joint];
  double dry = f->friction_share * d->coulomb_Nm, viscous = f->viscous_share * d->viscous_Nms_rad,
         constant = offset_of(s, f, joint);
  size_t i;

  for (i = 0; i < s->n; i++)
    column[i] += torque[i] - (p->load_Nm[joint][i] - turning * s->a[joint][i] + constant +
                              dry * s->slip[joint][i] + viscous * s->v[joint][i]);
}

/* what the other joint feels of a link that stands `angle` ahead and accelerates by itself */
static void add_other_torque(tl_effect_prepared *p, int joint, double *const shift[3], double *acceleration,
                             int other, double *column) {
  double *const moved[3] = {shift[0], shift[1], acceleration};
  size_t i;

  tl_columns_rates(p->segment, shift);
  for (i = 0; i < p->segment->n; i++) acceleration[i] -= p->segment->a[joint][i];
  tl_columns_add_shift(p, joint, moved, other, column);
}

/* a link's parts of its memory, n rows each */
enum { ANGLE, TORQUE, OTHER, ACCELERATION, ROWS, PARTS = ROWS + 2 };

size_t tl_effect_link_memory(size_t n) {
  return PARTS * n;
}

static double *part_of(const tl_columns_link *l, int part) {
  return l->work + (size_t)part * l->p->segment->n;
}

/* What is to be stepped of a link, and what of it turns with its motor; 0 where there is none. */
static int begin_link(const tl_columns_link *l, int joint, tl_two_mass_run *run, double *turning) {
  const tl_effect_segment *s = l->p->segment;
  const double *load = tl_columns_load(l->p, joint);
  double *other = part_of(l, OTHER), constant = offset_of(s, &l->joint, joint);
  size_t i;

  run->link = link_of(l->p, &l->joint, joint, turning);
  if (!(run->link.inertia_kg_m2 > 0.0)) return 0;
  set_rows(l->p, joint, part_of(l, ROWS), &run->link);
  for (i = 0; i < s->n; i++)
    other[i] = load[i] + constant - (*turning + run->link.row_inertia_kg_m2[i]) * s->a[joint][i];
  run->t_s = s->t_s;
  run->motor_rad = s->q[joint];
  run->motor_rad_s = s->v[joint];
  run->other_Nm = other;
  run->n = s->n;
  run->out.angle_rad = part_of(l, ANGLE);
  run->out.torque_Nm = part_of(l, TORQUE);
  run->out.link_rad_s2 = part_of(l, ACCELERATION);
  return 1;
}

static void tell_link(const tl_columns_link *l, int joint, double turning) {
  const tl_effect_segment *s = l->p->segment;
  double *angle = part_of(l, ANGLE), *torque = part_of(l, TORQUE), *column;
  double *const shift[3] = {angle, torque,
                            part_of(l, OTHER)}; /* the last two are not needed any more, then */
  int c;

  for (c = TL_MAX_JOINTS; c < TL_EFFECT_CHANNELS; c++) {
    column = tl_columns_sees(joint, c) ? tl_columns_of(l->p, &l->wanted, c, 0) : NULL;
    if (column) memcpy(column, angle, s->n * sizeof *column);
  }
  if ((column = tl_columns_of(l->p, &l->wanted, joint, 0)))
    add_own_torque(l->p, &l->joint, joint, turning, torque, column);
  for (c = 0; c < tl_joint_count(s->model); c++)
    if (c != joint && (column = tl_columns_of(l->p, &l->wanted, c, 0)))
      add_other_torque(l->p, joint, shift, part_of(l, ACCELERATION), c, column);
}

void tl_columns_links(tl_columns_link *link, int links, int joint) {
  tl_two_mass_run run[TL_TWO_MASS_LANES];
  double turning[TL_TWO_MASS_LANES];
  int there[TL_TWO_MASS_LANES], k, runs = 0;

  memset(run, 0, sizeof run);
  for (k = 0; k < links; k++)
    if (begin_link(&link[k], joint, &run[runs], &turning[runs])) there[runs++] = k;
  tl_two_mass_along_each(run, (size_t)runs);
  for (k = 0; k < runs; k++) tell_link(&link[there[k]], joint, turning[k]);
}
