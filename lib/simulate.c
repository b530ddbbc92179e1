/* simulate.c: see talus/experimental/simulate.h.
 *
 * With joint friction f_j = coulomb_j slip_j the accelerations are
 *     M a = r - f,  r everything else at the instant,
 * which tl_forward solves for given slip. A sticking joint has a = 0, and that
 * equation gives its f instead. Of joints at rest, those move whose friction
 * would have to exceed its Coulomb level. The unique solution (M is positive
 * definite: it minimises a'M a/2 - r'a + sum of coulomb |a|) is found among the
 * few patterns of directions.
 */
#include "talus/experimental/simulate.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "math_inline.h"
#include "simulate_effects.h"

#define CROWDED_S 1e-9 /* changes closer than this, so many times in a row, lead nowhere */
#define MAX_CROWDED 100
#define MAX_ROOT_STEPS 200
#define BORDER 1e-9 /* of the Coulomb level: sticking or sliding, rounding decides */
/* effects may be stiff or bend: their steps keep the error of velocity, by the embedded formula of
 * third order, below this, and are no shorter than this share of the step asked for */
#define STEP_ERROR 1e-7
#define SHORTEST (1.0 / 256.0)

/* a place on the way: the motion there (its a and slip by the modes), the energies, and their rates */
typedef struct point {
  tl_motion motion;
  double work, dissipated;
  double power, loss;
  int whole; /* 1: `beyond` counts */
  tl_link_state beyond;
} point;

/* most plants have nothing beyond: then it is not carried along */
static void copy_point(point *to, const point *from) {
  memcpy(to, from, offsetof(point, beyond));
  if (from->whole) to->beyond = from->beyond;
}

/* the plant and what drives it, fixed during a call */
typedef struct plant {
  const tl_model *model;
  tl_torque_law law;
  const void *context;
  int joints;
  tl_effect_dynamics acting; /* with effects, if there are any */
} plant;

void tl_held_torque(const void *context, double t_s, const tl_motion *motion, double torque[TL_MAX_JOINTS]) {
  const double *held = context;

  (void)t_s;
  (void)motion;
  torque[0] = held[0];
  torque[1] = held[1];
}

/* ---- accelerations ----------------------------------------------------------- */

/* The joints' slip and acceleration for given modes. Sliding joints take theirs from the mode;
 * for the sticking ones S beside the moving ones F, a0 being the accelerations without f_S:
 *     M_FF a_F = M_FF a0_F + M_FS a0_S,   f_S = M_SF (a0_F - a_F) + M_SS a0_S.
 * slip of a sticking joint may come out beyond +-1: then it cannot stick. */
static tl_status accelerate(const plant *p, const tl_joint_mode *mode, const double torque[TL_MAX_JOINTS],
                            tl_motion *motion) {
  double matrix[TL_MAX_JOINTS * TL_MAX_JOINTS], friction[TL_MAX_JOINTS], a0[TL_MAX_JOINTS];
  int j, other, sticking = 0;
  tl_status status;

  for (j = 0; j < p->joints; j++) {
    sticking += mode[j] == TL_MODE_STICK;
    motion->slip[j] = mode[j] == TL_MODE_FREE ? 0.0 : (double)mode[j];
  }
  status = tl_forward(p->model, torque, motion);
  if (status != TL_OK || sticking == 0) return status;

  tl_inertia_matrix(p->model, motion->q, matrix);
  memcpy(a0, motion->a, sizeof a0);
  for (j = 0; j < p->joints; j++) /* one moves while the other sticks */
    for (other = 0; other < p->joints; other++)
      if (sticking < p->joints && mode[j] != TL_MODE_STICK && other != j)
        motion->a[j] = a0[j] + matrix[j * p->joints + other] * a0[other] / matrix[j * p->joints + j];
  for (j = 0; j < p->joints; j++) {
    if (mode[j] != TL_MODE_STICK) continue;
    motion->a[j] = 0.0;
    friction[j] = 0.0;
    for (other = 0; other < p->joints; other++)
      friction[j] += matrix[j * p->joints + other] *
                     (a0[other] - (mode[other] == TL_MODE_STICK ? 0.0 : motion->a[other]));
    motion->slip[j] = friction[j] / p->model->drive[j].coulomb_Nm;
  }
  return TL_OK;
}

/* The right-hand side: accelerations and powers at x's positions and velocities. All that acts on the
 * plant meets here: the law's torque, friction through `slip`, and effects. */
static tl_status evaluate(const plant *p, const tl_joint_mode *mode, double t, point *x) {
  double torque[TL_MAX_JOINTS] = {0.0, 0.0}, joint[TL_MAX_JOINTS];
  tl_motion *now = &x->motion;
  tl_status status;
  int j;

  p->law(p->context, t, now, torque);
  x->power = x->loss = 0.0;
  status = p->acting.effects
               ? tl_effect_dynamics_accelerate(&p->acting, t, mode, torque, now, &x->beyond, &x->loss)
               : accelerate(p, mode, torque, now);
  if (status != TL_OK) return status;
  tl_joint_torque(p->model, now->q, torque, joint);
  for (j = 0; j < p->joints; j++) x->power += (joint[j] - tl_joint_offset(p->model, j)) * now->v[j];
  for (j = 0; j < p->joints && !p->acting.effects; j++) {
    const tl_drive *d = &p->model->drive[j];
    x->loss += (d->coulomb_Nm * now->slip[j] + d->viscous_Nms_rad * now->v[j]) * now->v[j];
  }
  return TL_OK;
}

/* ---- one step ---------------------------------------------------------------- */

/* what effects add to the state, along its rates */
static void beyond_along(tl_link_state *y, double h, const tl_link_state *slope) {
  int j;

  for (j = 0; j <= TL_MAX_JOINTS; j++) {
    y->q[j] += h * slope->v[j];
    y->v[j] += h * slope->a[j];
  }
  for (j = 0; j < TL_MAX_JOINTS; j++) y->z[j] += h * slope->z_rate[j];
}

/* from x along the rates of `slope` for a time h */
static void step_along(const point *x, double h, const point *slope, point *y) {
  int j;

  copy_point(y, x);
  for (j = 0; j < TL_MAX_JOINTS; j++) {
    y->motion.q[j] += h * slope->motion.v[j];
    y->motion.v[j] += h * slope->motion.a[j];
  }
  y->work += h * slope->power;
  y->dissipated += h * slope->loss;
  if (x->whole) beyond_along(&y->beyond, h, &slope->beyond);
}

static void add_beyond(tl_link_state *mean, double weight, const tl_link_state *rates) {
  int j;

  for (j = 0; j <= TL_MAX_JOINTS; j++) {
    mean->v[j] += weight * rates->v[j];
    mean->a[j] += weight * rates->a[j];
  }
  for (j = 0; j < TL_MAX_JOINTS; j++) mean->z_rate[j] += weight * rates->z_rate[j];
}

/* the rates of the classical Runge-Kutta step, from those at its four points */
static void mean_slope(const point k[4], point *mean) {
  static const double weight[4] = {1.0 / 6.0, 2.0 / 6.0, 2.0 / 6.0, 1.0 / 6.0};
  int i, j;

  memset(mean, 0, k[0].whole ? sizeof *mean : offsetof(point, beyond));
  for (i = 0; i < 4; i++) {
    for (j = 0; j < TL_MAX_JOINTS; j++) {
      mean->motion.v[j] += weight[i] * k[i].motion.v[j];
      mean->motion.a[j] += weight[i] * k[i].motion.a[j];
    }
    mean->power += weight[i] * k[i].power;
    mean->loss += weight[i] * k[i].loss;
    if (k[0].whole) add_beyond(&mean->beyond, weight[i], &k[i].beyond);
  }
}

/* a step from one place under fixed modes, of any length */
typedef struct attempt {
  const plant *p;
  const tl_joint_mode *mode;
  double t;
  const point *begin; /* evaluated */
  point end;          /* of the last length that was tried, evaluated */
  double error;       /* of its velocities */
} attempt;

/* The largest difference of the rates of velocity. The end's own rates in the place of the fourth make a
 * formula of third order, so over 6 this is its difference from that of fourth order. */
static double difference(const point *fourth, const point *end) {
  double worst = 0.0, off;
  int j;

  for (j = 0; j <= TL_MAX_JOINTS; j++) {
    off = fabs(fourth->beyond.a[j] - end->beyond.a[j]);
    if (!(off <= worst)) worst = off;
    if (j == TL_MAX_JOINTS) break;
    off = fabs(fourth->motion.a[j] - end->motion.a[j]);
    if (!(off <= worst)) worst = off;
    off = fabs(fourth->beyond.z_rate[j] - end->beyond.z_rate[j]);
    if (!(off <= worst)) worst = off;
  }
  return worst;
}

static tl_status try_length(attempt *a, double h) {
  static const double share[4] = {0.0, 0.5, 0.5, 1.0};
  point k[4], mean;
  tl_status status = TL_OK;
  int i;

  copy_point(&k[0], a->begin);
  for (i = 1; i < 4 && status == TL_OK; i++) {
    step_along(a->begin, share[i] * h, &k[i - 1], &k[i]);
    status = evaluate(a->p, a->mode, a->t + share[i] * h, &k[i]);
  }
  if (status != TL_OK) return status;
  mean_slope(k, &mean);
  step_along(a->begin, h, &mean, &a->end);
  status = evaluate(a->p, a->mode, a->t + h, &a->end);
  a->error = a->p->acting.effects ? h / 6.0 * difference(&k[3], &a->end) : 0.0;
  return status;
}

/* a step of at most h, which becomes the length that keeps the error where effects act */
static tl_status try_step(attempt *a, double *h) {
  double shortest = SHORTEST * *h;
  tl_status status = try_length(a, *h);

  while (a->p->acting.effects && status == TL_OK && !(a->error <= STEP_ERROR) && *h > shortest) {
    *h *= 0.5;
    status = try_length(a, *h);
  }
  return status;
}

/* ---- changes of mode ----------------------------------------------------------- */

/* how far joint j is into what its mode forbids: > 0 means that a change lies behind */
static double trespass(tl_joint_mode mode, int j, const point *x) {
  if (mode == TL_MODE_FREE) return -1.0;
  if (mode == TL_MODE_STICK) return fabs(x->motion.slip[j]) - 1.0;
  return -(double)mode * x->motion.v[j];
}

/* The length at which joint j's trespass begins, within TL_EVENT_TIME_S: it is <= 0 at no length and
 * at_high > 0 at *high, which becomes the end just beyond the change. Regula falsi (Illinois), every
 * third step a bisection. */
static tl_status locate(attempt *a, int j, double at_low, double at_high, double *high) {
  double low = 0.0;
  int i, side = 0;

  for (i = 0; i<MAX_ROOT_STEPS && * high - low> TL_EVENT_TIME_S; i++) {
    double h = low + (*high - low) * (at_low / (at_low - at_high)), value;
    tl_status status;
    if (i % 3 == 2 || !(h > low && h < *high)) h = 0.5 * (low + *high);
    status = try_length(a, h);
    if (status != TL_OK) return status;
    value = trespass(a->mode[j], j, &a->end);
    if (value > 0.0) {
      *high = h;
      at_high = value;
      if (side > 0) at_low *= 0.5;
      side = 1;
    } else {
      low = h;
      at_low = value;
      if (side < 0) at_high *= 0.5;
      side = -1;
    }
  }
  return TL_OK;
}

/* the first change within a step of *h that has been tried: *h becomes its instant; bit j of the
 * answer's *changed says that joint j changes there */
static tl_status first_change(attempt *a, double *h, int *changed) {
  double at[TL_MAX_JOINTS], whole = *h;
  point end;
  int j;

  copy_point(&end, &a->end);
  *changed = 0;
  for (j = 0; j < a->p->joints; j++) {
    double beyond = trespass(a->mode[j], j, &end);
    tl_status status;
    at[j] = whole;
    if (!(beyond > 0.0)) continue;
    status = locate(a, j, trespass(a->mode[j], j, a->begin), beyond, &at[j]);
    if (status != TL_OK) return status;
    *changed |= 1 << j;
    if (at[j] < *h) *h = at[j];
  }
  for (j = 0; j < a->p->joints; j++)
    if (at[j] > *h) *changed &= ~(1 << j);
  return *changed ? try_length(a, *h) : TL_OK;
}

/* do the joints at rest agree with their modes? A sticking one to `tolerance` of its Coulomb level. */
static int is_consistent(const plant *p, const tl_joint_mode *mode, const point *x, double tolerance) {
  int j;

  for (j = 0; j < p->joints; j++) {
    if (mode[j] == TL_MODE_FREE || x->motion.v[j] != 0.0) continue;
    if (mode[j] == TL_MODE_STICK && !(fabs(x->motion.slip[j]) <= 1.0 + tolerance)) return 0;
    if (mode[j] != TL_MODE_STICK && !((double)mode[j] * x->motion.a[j] > 0.0)) return 0;
  }
  return 1;
}

/* Modes from what the joints do now, and the rates that follow. The direction of a joint at rest is
 * looked for among all patterns, sticking first; a second round forgives rounding at the border. */
static tl_status settle(const plant *p, double t, tl_joint_mode *mode, point *x) {
  static const tl_joint_mode choice[3] = {TL_MODE_STICK, TL_MODE_FORWARD, TL_MODE_BACKWARD};
  int pattern, round, j, at_rest[TL_MAX_JOINTS] = {0, 0};

  for (j = 0; j < p->joints; j++) {
    if (!tl_effect_dynamics_is_dry(&p->acting, j))
      mode[j] = TL_MODE_FREE;
    else if (x->motion.v[j] != 0.0)
      mode[j] = x->motion.v[j] > 0.0 ? TL_MODE_FORWARD : TL_MODE_BACKWARD;
    else
      at_rest[j] = 1;
  }
  for (round = 0; round < 2; round++) {
    for (pattern = 0; pattern < 9; pattern++) {
      int digit[TL_MAX_JOINTS] = {pattern % 3, pattern / 3};
      tl_status status;
      if ((!at_rest[0] && digit[0] != 0) || (!at_rest[1] && digit[1] != 0)) continue;
      for (j = 0; j < TL_MAX_JOINTS; j++)
        if (at_rest[j]) mode[j] = choice[digit[j]];
      status = evaluate(p, mode, t, x);
      if (status != TL_OK) return status;
      if (is_consistent(p, mode, x, round == 0 ? 0.0 : BORDER)) return TL_OK;
    }
  }
  return TL_ERR_NO_CONVERGENCE;
}

/* ---- in time ------------------------------------------------------------------- */

static int coulomb_is_unsupported(const tl_model *m, const tl_effect_dynamics *acting) {
  return m->form == TL_FORM_PAPER &&
         (m->drive[0].coulomb_Nm > 0.0 || m->drive[1].coulomb_Nm > 0.0 || (acting && acting->effects > 0));
}

tl_status tl_simulation_init(tl_simulation *s, const tl_model *m, const double q[TL_MAX_JOINTS],
                             const double v[TL_MAX_JOINTS]) {
  tl_simulation made;
  int j;

  if (!s || !m || !q || !v || tl_joint_count(m) == 0) return TL_ERR_ARGUMENT;
  if (coulomb_is_unsupported(m, NULL)) return TL_ERR_UNSUPPORTED;
  memset(&made, 0, sizeof made);
  for (j = 0; j < tl_joint_count(m); j++) {
    if (!tl_is_finite(q[j]) || !tl_is_finite(v[j])) return TL_ERR_NOT_FINITE;
    made.motion.q[j] = q[j];
    made.motion.v[j] = v[j];
  }
  *s = made;
  return TL_OK;
}

static int is_sound(const point *x) {
  const tl_motion *m = &x->motion;
  double beyond = x->whole ? x->beyond.q[0] + x->beyond.q[1] + x->beyond.q[2] : 0.0;

  return tl_is_finite(m->q[0]) && tl_is_finite(m->q[1]) && tl_is_finite(m->v[0]) && tl_is_finite(m->v[1]) &&
         tl_is_finite(x->work) && tl_is_finite(x->dissipated) && tl_is_finite(beyond);
}

static void keep(tl_simulation *s, double t, const point *x) {
  s->t_s = t;
  s->motion = x->motion;
  s->work_J = x->work;
  s->dissipated_J = x->dissipated;
  if (x->whole) s->beyond = x->beyond;
}

/* One step towards until_s, to the next change at most; *changed as first_change says. */
static tl_status advance(const plant *p, double step_s, double until_s, tl_simulation *s, point *x,
                         int *changed) {
  double left = until_s - s->t_s, steps = floor(left / step_s + (1.0 - 1e-9)), whole, h;
  attempt a = {.p = p, .mode = s->mode, .t = s->t_s, .begin = x};
  tl_status status;
  int j;

  h = whole = steps > 1.0 ? left / steps : left;
  status = try_step(&a, &h);
  if (h < whole) steps = 2.0; /* not there yet */
  if (status == TL_OK && is_sound(&a.end)) status = first_change(&a, &h, changed);
  if (status != TL_OK) return status;
  if (!is_sound(&a.end)) return TL_ERR_NOT_FINITE;
  copy_point(x, &a.end);
  for (j = 0; j < p->joints; j++)
    if (*changed >> j & 1) x->motion.v[j] = 0.0;
  keep(s, *changed == 0 && !(steps > 1.0) ? until_s : s->t_s + h, x);
  return TL_OK;
}

static void set_plant(plant *p, const tl_model *m, tl_torque_law law, const void *context,
                      const tl_simulation *s) {
  p->model = p->acting.model = m;
  p->law = law;
  p->context = context;
  p->acting.effect = s->effect;
  p->acting.effects = s->effects;
  p->acting.begin_s = s->effects_begin_s;
  tl_effect_dynamics_init(&p->acting);
  p->joints = p->acting.joints;
}

void tl_simulation_joints(const tl_simulation *s, tl_motion *joints) {
  tl_effect_change c;
  int j;

  *joints = s->motion;
  for (j = 0; j < TL_MAX_JOINTS && s->beyond.begun; j++) {
    c = tl_effects_change(s->effect, s->effects, j);
    if (!(c.compliance_rad_Nm > 0.0)) continue;
    joints->q[j] = s->beyond.q[j];
    joints->v[j] = s->beyond.v[j];
    joints->a[j] = s->beyond.a[j];
  }
}

tl_status tl_simulate(const tl_model *m, tl_torque_law law, const void *context, double step_s,
                      tl_simulation *s, double until_s) {
  plant p;
  point x;
  double last_change_s = -HUGE_VAL;
  int changed = 0, crowded = 0;
  tl_status status;

  if (!m || !law || !s || !(step_s > 0.0) || !(until_s >= s->t_s)) return TL_ERR_ARGUMENT;
  set_plant(&p, m, law, context, s);
  if (coulomb_is_unsupported(m, &p.acting)) return TL_ERR_UNSUPPORTED;
  memset(&x, 0, s->effects > 0 ? sizeof x : offsetof(point, beyond));
  x.motion = s->motion;
  if (s->effects > 0) {
    x.whole = 1;
    x.beyond = s->beyond;
    tl_effect_dynamics_begin(&p.acting, &x.motion, &x.beyond);
  }
  x.work = s->work_J;
  x.dissipated = s->dissipated_J;
  /* the torque may have jumped since the last call */
  status = settle(&p, s->t_s, s->mode, &x);
  while (status == TL_OK && s->t_s < until_s) {
    status = advance(&p, step_s, until_s, s, &x, &changed);
    if (status != TL_OK || !changed) continue;
    s->changes++;
    crowded = s->t_s - last_change_s < CROWDED_S ? crowded + 1 : 0;
    last_change_s = s->t_s;
    status = crowded > MAX_CROWDED ? TL_ERR_NO_CONVERGENCE : settle(&p, s->t_s, s->mode, &x);
  }
  if (status == TL_OK) keep(s, until_s, &x);
  return status;
}
