/* along.c: see along.h and link.h. */
#include "along.h"

#include <math.h>
#include <string.h>

#include "talus/math.h"

#define SMALL 1e-5 /* [rad]: step of the slopes of the inverse dynamics */

size_t tl_effect_stretch_work(size_t n) {
  return 4 * n;
}

/* ---- models ------------------------------------------------------------------ */

static void make_rigid(tl_transmission *t) {
  t->kind = TL_TRANSMISSION_FIXED;
  t->ratio = 1.0;
}

tl_model tl_effect_bare_model(const tl_model *m) {
  tl_model bare = *m;
  int j;

  for (j = 0; j < TL_MAX_JOINTS; j++) {
    bare.drive[j].coulomb_Nm = bare.drive[j].viscous_Nms_rad = 0.0;
    make_rigid(&bare.drive[j].transmission);
    bare.drive[j].rotor_inertia_kg_m2 = 0.0;
  }
  bare.torque_offset_Nm = bare.force_offset_N = 0.0;
  return bare;
}

void tl_effect_take_motor(tl_model *m, int joint) {
  make_rigid(&m->drive[joint].transmission);
  m->drive[joint].rotor_inertia_kg_m2 = 0.0;
  if (joint != 0) return;
  m->shank_inertia_kg_m2 *= 1.0 - TL_EFFECT_MOTOR_SHARE;
  m->inertia_kg_m2 *= 1.0 - TL_EFFECT_MOTOR_SHARE;
  m->mass_kg *= 1.0 - TL_EFFECT_MOTOR_SHARE;
}

tl_model tl_effect_link_model(const tl_model *m, int joint) {
  tl_model link = tl_effect_bare_model(m);

  tl_effect_take_motor(&link, joint);
  return link;
}

tl_status tl_effect_change_linkage(const tl_effect_change *c, const tl_transmission *t,
                                   tl_transmission *changed) {
  tl_screw_linkage linkage = t->linkage;

  *changed = *t;
  if (c->AB_m == 0.0 && c->BO_m == 0.0 && c->AC_m == 0.0) return TL_OK;
  if (t->kind != TL_TRANSMISSION_SCREW_LINKAGE) return TL_ERR_UNSUPPORTED;
  linkage.AB_m += c->AB_m;
  linkage.BO_m += c->BO_m;
  linkage.AC_m += c->AC_m;
  return tl_transmission_screw_linkage(changed, &linkage);
}

/* ---- rows -------------------------------------------------------------------- */

void tl_along_nothing(double *column, size_t n) {
  size_t i;

  for (i = 0; i < n; i++) column[i] = 0.0;
}

void tl_along_copy(double *column, const double *from, size_t n) {
  memcpy(column, from, n * sizeof *column);
}

void tl_along_motion(const tl_effect_stretch *s, size_t i, tl_motion *now) {
  int j;

  memset(now, 0, sizeof *now);
  for (j = 0; j < tl_joint_count(s->model); j++) {
    now->q[j] = s->q[j][i];
    now->v[j] = s->v[j][i];
    now->a[j] = s->a[j][i];
    now->slip[j] = s->slip[j][i];
  }
}

void tl_along_plain_torque(const tl_effect_stretch *s, int joint, double *torque) {
  double at_once[TL_MAX_JOINTS];
  tl_motion now;
  size_t i;

  for (i = 0; i < s->n; i++) {
    tl_along_motion(s, i, &now);
    tl_inverse(s->model, &now, at_once);
    tl_joint_torque(s->model, now.q, at_once, at_once);
    torque[i] = at_once[joint];
  }
}

void tl_along_load(const tl_effect_stretch *s, const tl_model *link, int joint, double *load) {
  tl_effect_stretch of_link = *s;

  of_link.model = link;
  tl_along_plain_torque(&of_link, joint, load);
}

/* ---- slopes of the inverse dynamics ---------------------------------------------- */

static double torque_beside(const tl_model *m, const tl_motion *now, int moved, const double d[3],
                            double step, int shows) {
  tl_motion beside = *now;
  double torque[TL_MAX_JOINTS];

  beside.q[moved] += step * d[0];
  beside.v[moved] += step * d[1];
  beside.a[moved] += step * d[2];
  tl_inverse(m, &beside, torque);
  return torque[shows];
}

/* change of a joint's torque by a shift d of a joint */
static double slope_of(const tl_model *m, const tl_motion *now, int moved, const double d[3], double step,
                       int shows) {
  double more = torque_beside(m, now, moved, d, step, shows),
         less = torque_beside(m, now, moved, d, -step, shows);

  return (more - less) * (0.5 / step);
}

void tl_along_shift(const tl_effect_stretch *s, const tl_model *m, int moved, double *const shift[3],
                    int shows, double *column) {
  double ratio[TL_MAX_JOINTS], unit[TL_MAX_JOINTS] = {1.0, 1.0};
  tl_motion now;
  size_t i;

  for (i = 0; i < s->n; i++) {
    const double d[3] = {shift[0][i], shift[1][i], shift[2][i]};
    double size = fabs(d[0]) + 0.1 * fabs(d[1]), step = size > SMALL ? SMALL / size : 1.0;
    tl_along_motion(s, i, &now);
    tl_joint_torque(m, now.q, unit, ratio);
    column[i] = slope_of(m, &now, moved, d, step, shows) * ratio[shows];
  }
}

void tl_along_twist(const tl_effect_stretch *s, const tl_model *link, int joint, double *const shift[4],
                    int shows, double *column) {
  int angle = joint == 0 ? shows == TL_EFFECT_SHOWS_SHANK : shows != TL_EFFECT_SHOWS_SHANK;

  tl_along_nothing(column, s->n);
  if (shows == joint)
    tl_along_copy(column, shift[3], s->n);
  else if (shows < TL_MAX_JOINTS)
    tl_along_shift(s, link, joint, shift, shows, column);
  else if (angle)
    tl_along_copy(column, shift[0], s->n);
}

/* ---- a spring under a load --------------------------------------------------------- */

/* in contact: the particular solution of a straight load is straight too, and what is left swings and decays
 * (exact for any h) */
static void swing_bound(const tl_along_spring *p, double centre, double from, double to, double h, double *x,
                        double *v) {
  double all = p->stiffness + p->pull, w = sqrt(all / p->inertia), decay = 0.5 * p->damping / p->inertia;
  double rate = -(to - from) / (h * all), lag = rate * p->damping / all;
  double end, swing, a, b, sine, cosine, gone;

  centre *= p->stiffness / all;
  end = centre - to / all - lag;
  decay = decay < 0.999 * w ? decay : 0.999 * w; /* beyond, it creeps faster than rows follow */
  swing = sqrt(w * w - decay * decay);
  a = *x - (centre - from / all - lag);
  b = (*v - rate + decay * a) / swing;
  tl_sincos(swing * h, &sine, &cosine);
  gone = tl_exp(-decay * h);
  *x = end + gone * (a * cosine + b * sine);
  *v = rate + gone * ((b * swing - decay * a) * cosine - (a * swing + decay * b) * sine);
}

void tl_along_swing(const tl_along_spring *p, double from, double to, double h, double *x, double *v) {
  if (fabs(*x) >= 0.5 * p->gap) {
    swing_bound(p, p->gap > 0.0 ? (*x < 0.0 ? -0.5 : 0.5) * p->gap : 0.0, from, to, h, x, v);
    return;
  }
  *x += h * (*v - h * (from / 3.0 + to / 6.0) / p->inertia);
  *v -= h * 0.5 * (from + to) / p->inertia;
}

/* torque on the motor's side */
static double spring_torque(const tl_along_spring *p, double x, double v) {
  double depth = fabs(x) - 0.5 * p->gap;

  if (p->gap > 0.0 && !(depth > 0.0)) return 0.0;
  return (x < 0.0 ? depth : -depth) * p->stiffness - p->damping * v;
}

/* Accelerations at both ends of the piece before row i whose integrals are its own angles and speeds: the
 * recorded ones are too smooth beside a stop to carry the motor to the next row. */
static void piece_ends(const tl_effect_stretch *s, int joint, size_t i, double a[2]) {
  double h = s->t_s[i] - s->t_s[i - 1], from = s->v[joint][i - 1], to = s->v[joint][i];
  double mean = (s->q[joint][i] - s->q[joint][i - 1]) / h;

  a[0] = (6.0 * mean - 4.0 * from - 2.0 * to) / h;
  a[1] = (2.0 * from + 4.0 * to - 6.0 * mean) / h;
}

static void swing_piece(const tl_effect_stretch *s, int joint, const tl_along_spring *spring, size_t i,
                        const double load[2], double *x, double *v) {
  int pieces = spring->gap > 0.0 ? 16 : 1, k;
  double a[2], from, to, h = (s->t_s[i] - s->t_s[i - 1]) / pieces;

  piece_ends(s, joint, i, a);
  from = load[0] + spring->inertia * (a[0] - s->a[joint][i - 1]);
  to = load[1] + spring->inertia * (a[1] - s->a[joint][i]);
  for (k = 0; k < pieces; k++)
    tl_along_swing(spring, from + (to - from) * k / pieces, from + (to - from) * (k + 1) / pieces, h, x, v);
}

void tl_along_link(const tl_effect_stretch *s, const tl_model *link, int joint, double stiffness,
                   double damping_s, double gap, double *const shift[4]) {
  tl_along_spring spring = {0.0, stiffness, damping_s * stiffness, gap, 0.0};
  double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS], x = 0.0, v = 0.0, load[2] = {0.0, 0.0}, torque;
  const double turn[3] = {1.0, 0.0, 0.0};
  int joints = tl_joint_count(link);
  tl_motion now;
  size_t i;

  tl_along_load(s, link, joint, shift[3]);
  for (i = 0; i < s->n; i++) {
    tl_along_motion(s, i, &now);
    tl_inertia_matrix(link, now.q, matrix);
    spring.inertia = matrix[joint * joints + joint];
    spring.pull = slope_of(link, &now, joint, turn, SMALL, joint);
    if (spring.pull < -0.5 * stiffness) spring.pull = -0.5 * stiffness;
    load[1] = shift[3][i];
    if (i == 0) x = -load[1] / stiffness - (load[1] < 0.0 ? -0.5 : 0.5) * gap;
    if (i > 0) swing_piece(s, joint, &spring, i, load, &x, &v);
    load[0] = load[1];
    torque = spring_torque(&spring, x, v);
    shift[0][i] = x;
    shift[1][i] = v;
    shift[2][i] = (torque - load[1] - spring.pull * x) / spring.inertia;
    shift[3][i] = torque - load[1];
  }
}
