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
  int whole; /* 1: `link` counts */
  tl_link_state link;
} point;

/* most plants have no link state: then it is not carried along */
static void copy_point(point *to, const point *from) {
  memcpy(to, from, offsetof(point, link));
  if (from->whole) to->link = from->link;
}

/* the plant and what drives it, fixed during a call */
typedef struct plant {
  const tl_model *model;
  tl_torque_law law;
  const void *context;
  int joints;
  int contacts, contact[TL_CONTACTS]; /* where dry friction may act */
  tl_effect_dynamics acting;          /* with effects, if there are any */
} plant;

/* speed, acceleration and slip at a contact */
static double speed_at(const plant *p, const point *x, int c) {
  if (c >= TL_CONTACT_DRAG)
    return tl_effect_dynamics_speed(&p->acting, c - TL_CONTACT_DRAG, &x->motion) -
           x->link.v[c - TL_CONTACT_DRAG];
  return c < TL_CONTACT_LINK ? x->motion.v[c] : x->link.v[c - TL_CONTACT_LINK];
}

static double acceleration_at(const point *x, int c) {
  if (c >= TL_CONTACT_DRAG) return x->link.drag_a[c - TL_CONTACT_DRAG];
  return c < TL_CONTACT_LINK ? x->motion.a[c] : x->link.a[c - TL_CONTACT_LINK];
}

static double slip_at(const point *x, int c) {
  if (c >= TL_CONTACT_DRAG) return x->link.drag_slip[c - TL_CONTACT_DRAG];
  return c < TL_CONTACT_LINK ? x->motion.slip[c] : x->link.slip[c - TL_CONTACT_LINK];
}

/* motor and link get one speed: 0 where the link rests */
static void join_at(const plant *p, point *x, int joint) {
  if (x->link.v[joint] == 0.0)
    x->motion.v[joint] = 0.0;
  else
    x->link.v[joint] = tl_effect_dynamics_speed(&p->acting, joint, &x->motion);
}

static void stop_at(const plant *p, point *x, int c) {
  if (c >= TL_CONTACT_DRAG)
    join_at(p, x, c - TL_CONTACT_DRAG);
  else
    *(c < TL_CONTACT_LINK ? &x->motion.v[c] : &x->link.v[c - TL_CONTACT_LINK]) = 0.0;
}

/* is there dry friction at a contact, so that it can stick? */
static int is_dry(const plant *p, int c) {
  if (c >= TL_CONTACT_DRAG) return tl_effect_dynamics_drag(&p->acting, c - TL_CONTACT_DRAG) > 0.0;
  if (c >= TL_CONTACT_LINK) return tl_effect_dynamics_link_friction(&p->acting, c - TL_CONTACT_LINK) > 0.0;
  return tl_effect_dynamics_is_dry(&p->acting, c);
}

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
        motion->a[j] =
            a0[j] + matrix[tl_entry(p->joints, j, other)] * a0[other] / matrix[tl_entry(p->joints, j, j)];
  for (j = 0; j < p->joints; j++) {
    if (mode[j] != TL_MODE_STICK) continue;
    motion->a[j] = 0.0;
    friction[j] = 0.0;
    for (other = 0; other < p->joints; other++)
      friction[j] += matrix[tl_entry(p->joints, j, other)] *
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
               ? tl_effect_dynamics_accelerate(&p->acting, t, mode, torque, now, &x->link, &x->loss)
               : accelerate(p, mode, torque, now);
  if (status != TL_OK) return status;
  tl_joint_torque(p->model, now->q, torque, joint);
  for (j = 0; j < p->joints; j++)
    x->power += joint[j] * now->v[j] - tl_effect_dynamics_offset_W(&p->acting, j, now, &x->link);
  for (j = 0; j < p->joints && !p->acting.effects; j++) {
    const tl_drive *d = &p->model->drive[j];
    x->loss += (d->coulomb_Nm * now->slip[j] + d->viscous_Nms_rad * now->v[j]) * now->v[j];
  }
  return TL_OK;
}

/* ---- one step ---------------------------------------------------------------- */

/* what effects add to the state, along its rates */
static void link_along(tl_link_state *y, double h, const tl_link_state *slope) {
  int j;

  for (j = 0; j < TL_LINK_BODIES; j++) {
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
  if (x->whole) link_along(&y->link, h, &slope->link);
}

static void add_link(tl_link_state *mean, double weight, const tl_link_state *rates) {
  int j;

  for (j = 0; j < TL_LINK_BODIES; j++) {
    mean->v[j] += weight * rates->v[j];
    mean->a[j] += weight * rates->a[j];
  }
  for (j = 0; j < TL_MAX_JOINTS; j++) mean->z_rate[j] += weight * rates->z_rate[j];
}

/* the rates of the classical Runge-Kutta step, from those at its four points */
static void mean_slope(const point k[4], point *mean) {
  static const double weight[4] = {1.0 / 6.0, 2.0 / 6.0, 2.0 / 6.0, 1.0 / 6.0};
  int i, j;

  memset(mean, 0, k[0].whole ? sizeof *mean : offsetof(point, link));
  for (i = 0; i < 4; i++) {
    for (j = 0; j < TL_MAX_JOINTS; j++) {
      mean->motion.v[j] += weight[i] * k[i].motion.v[j];
      mean->motion.a[j] += weight[i] * k[i].motion.a[j];
    }
    mean->power += weight[i] * k[i].power;
    mean->loss += weight[i] * k[i].loss;
    if (k[0].whole) add_link(&mean->link, weight[i], &k[i].link);
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

/* the larger of `worst` and the difference, which may not be a number */
static double larger(double worst, double a, double b) {
  double off = fabs(a - b);

  return off <= worst ? worst : off;
}

/* The largest difference of the rates of velocity. The end's own rates in the place of the fourth make a
 * formula of third order, so over 6 this is its difference from that of fourth order. */
static double difference(const point *fourth, const point *end) {
  double worst = 0.0;
  int j;

  for (j = 0; j < TL_LINK_BODIES; j++) worst = larger(worst, fourth->link.a[j], end->link.a[j]);
  for (j = 0; j < TL_MAX_JOINTS; j++) worst = larger(worst, fourth->motion.a[j], end->motion.a[j]);
  for (j = 0; j < TL_MAX_JOINTS; j++) worst = larger(worst, fourth->link.z_rate[j], end->link.z_rate[j]);
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

/* how far contact c is into what its mode forbids: > 0 means that a change lies behind */
static double trespass(const plant *p, tl_joint_mode mode, int c, const point *x) {
  if (mode == TL_MODE_FREE) return -1.0;
  if (mode == TL_MODE_STICK) return fabs(slip_at(x, c)) - 1.0;
  return -(double)mode * speed_at(p, x, c);
}

/* The length at which contact c's trespass begins, within TL_EVENT_TIME_S: it is <= 0 at no length and
 * at_high > 0 at *high, which becomes the end just beyond the change. Regula falsi (Illinois), every
 * third step a bisection. */
static tl_status locate(attempt *a, int c, double at_low, double at_high, double *high) {
  double low = 0.0;
  int i, side = 0;

  for (i = 0; i<MAX_ROOT_STEPS && * high - low> TL_EVENT_TIME_S; i++) {
    double h = low + (*high - low) * (at_low / (at_low - at_high)), value;
    tl_status status;
    if (i % 3 == 2 || !(h > low && h < *high)) h = 0.5 * (low + *high);
    status = try_length(a, h);
    if (status != TL_OK) return status;
    value = trespass(a->p, a->mode[c], c, &a->end);
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

/* the first change within a step of *h that has been tried: *h becomes its instant; bit c of the
 * answer's *changed says that contact c changes there */
static tl_status first_change(attempt *a, double *h, int *changed) {
  double at[TL_CONTACTS], whole = *h;
  point end;
  int k;

  copy_point(&end, &a->end);
  *changed = 0;
  for (k = 0; k < a->p->contacts; k++) {
    int c = a->p->contact[k];
    double beyond = trespass(a->p, a->mode[c], c, &end);
    tl_status status;
    at[k] = whole;
    if (!(beyond > 0.0)) continue;
    status = locate(a, c, trespass(a->p, a->mode[c], c, a->begin), beyond, &at[k]);
    if (status != TL_OK) return status;
    *changed |= 1 << c;
    if (at[k] < *h) *h = at[k];
  }
  for (k = 0; k < a->p->contacts; k++)
    if (at[k] > *h) *changed &= ~(1 << a->p->contact[k]);
  return *changed ? try_length(a, *h) : TL_OK;
}

/* do the contacts at rest agree with their modes? A sticking one to `tolerance` of its Coulomb level. */
static int is_consistent(const plant *p, const tl_joint_mode *mode, const point *x, double tolerance) {
  int k;

  for (k = 0; k < p->contacts; k++) {
    int c = p->contact[k];
    if (mode[c] == TL_MODE_FREE || speed_at(p, x, c) != 0.0) continue;
    if (mode[c] == TL_MODE_STICK && !(fabs(slip_at(x, c)) <= 1.0 + tolerance)) return 0;
    if (mode[c] != TL_MODE_STICK && !((double)mode[c] * acceleration_at(x, c) > 0.0)) return 0;
  }
  return 1;
}

/* modes of the contacts that slide or are free; at_rest[] those whose direction is to be found, and their number */
static int moving_modes(const plant *p, const point *x, tl_joint_mode *mode, int at_rest[TL_CONTACTS]) {
  int k, rest = 0;

  for (k = 0; k < p->contacts; k++) {
    int c = p->contact[k];
    double v = speed_at(p, x, c);
    if (!is_dry(p, c))
      mode[c] = TL_MODE_FREE;
    else if (v != 0.0)
      mode[c] = v > 0.0 ? TL_MODE_FORWARD : TL_MODE_BACKWARD;
    else
      at_rest[rest++] = c;
  }
  return rest;
}

/* Modes from what the contacts do now, and the rates that follow. The direction of one at rest is
 * looked for among all patterns, sticking first; a second round forgives rounding at the border. */
static tl_status settle(const plant *p, double t, tl_joint_mode *mode, point *x) {
  static const tl_joint_mode choice[3] = {TL_MODE_STICK, TL_MODE_FORWARD, TL_MODE_BACKWARD};
  int at_rest[TL_CONTACTS], rest = moving_modes(p, x, mode, at_rest), patterns = 1, pattern, round, k, digit;

  for (k = 0; k < rest; k++) patterns *= 3;
  for (round = 0; round < 2; round++) {
    for (pattern = 0; pattern < patterns; pattern++) {
      tl_status status;
      for (k = 0, digit = pattern; k < rest; k++, digit /= 3) mode[at_rest[k]] = choice[digit % 3];
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
  double link = 0.0;
  int j;

  for (j = 0; j < TL_LINK_BODIES && x->whole; j++) link += x->link.q[j];

  return tl_is_finite(m->q[0]) && tl_is_finite(m->q[1]) && tl_is_finite(m->v[0]) && tl_is_finite(m->v[1]) &&
         tl_is_finite(x->work) && tl_is_finite(x->dissipated) && tl_is_finite(link);
}

static void keep(tl_simulation *s, double t, const point *x) {
  s->t_s = t;
  s->motion = x->motion;
  s->work_J = x->work;
  s->dissipated_J = x->dissipated;
  if (x->whole) s->link = x->link;
}

/* One step towards until_s, to the next change at most; *changed as first_change says. */
static tl_status advance(const plant *p, double step_s, double until_s, tl_simulation *s, point *x,
                         int *changed) {
  double left = until_s - s->t_s, steps = floor(left / step_s + (1.0 - 1e-9)), whole, h;
  attempt a = {.p = p, .mode = s->mode, .t = s->t_s, .begin = x};
  tl_status status;
  int k;

  h = whole = steps > 1.0 ? left / steps : left;
  status = try_step(&a, &h);
  if (h < whole) steps = 2.0; /* not there yet */
  if (status == TL_OK && is_sound(&a.end)) status = first_change(&a, &h, changed);
  if (status != TL_OK) return status;
  if (!is_sound(&a.end)) return TL_ERR_NOT_FINITE;
  copy_point(x, &a.end);
  for (k = 0; k < p->contacts; k++) {
    int c = p->contact[k], joined = c >= TL_CONTACT_DRAG && s->mode[c] == TL_MODE_STICK;
    if (joined || (*changed >> c & 1)) stop_at(p, x, c);
  }
  keep(s, *changed == 0 && !(steps > 1.0) ? until_s : s->t_s + h, x);
  return TL_OK;
}

static void set_plant(plant *p, const tl_model *m, tl_torque_law law, const void *context,
                      const tl_simulation *s) {
  int j;

  p->model = p->acting.model = m;
  p->law = law;
  p->context = context;
  p->acting.effect = s->effect;
  p->acting.effects = s->effects;
  p->acting.begin_s = s->effects_begin_s;
  tl_effect_dynamics_init(&p->acting);
  p->joints = p->acting.joints;
  p->contacts = 0;
  for (j = 0; j < p->joints; j++) p->contact[p->contacts++] = j;
  for (j = 0; j < p->joints; j++)
    if (tl_effect_dynamics_link_friction(&p->acting, j) > 0.0)
      p->contact[p->contacts++] = TL_CONTACT_LINK + j;
  for (j = 0; j < p->joints; j++)
    if (tl_effect_dynamics_drag(&p->acting, j) > 0.0) p->contact[p->contacts++] = TL_CONTACT_DRAG + j;
}

/* a rigid joint ahead of its motor's motion */
static void run_ahead(const tl_model *m, const tl_effect_change *c, int j, tl_motion *joints) {
  double ahead[3], v = joints->v[j];

  tl_effect_dynamics_ahead(m, c, j, joints->q[j], ahead);
  joints->q[j] += ahead[0];
  joints->v[j] = v * (1.0 + ahead[1]);
  joints->a[j] = joints->a[j] * (1.0 + ahead[1]) + ahead[2] * v * v;
}

double tl_simulation_base_angle(const tl_simulation *s) {
  tl_effect_change base;
  double angle = 0.0;
  int k;

  if (!s->link.begun) return 0.0;
  base = tl_effects_change(s->effect, s->effects, TL_MAX_JOINTS);
  for (k = 0; k < base.mount_modes && k < TL_MOUNT_MODES; k++)
    if (base.mount[k].mode == TL_MOUNT_TURNS) angle += s->link.q[TL_MAX_JOINTS + k];
  return angle;
}

void tl_simulation_joints(const tl_model *m, const tl_simulation *s, tl_motion *joints) {
  tl_effect_change c;
  int j;

  *joints = s->motion;
  for (j = 0; j < TL_MAX_JOINTS && s->link.begun; j++) {
    c = tl_effects_change(s->effect, s->effects, j);
    if (!(c.compliance_rad_Nm > 0.0)) {
      if (c.ripple.n > 0) run_ahead(m, &c, j, joints);
      continue;
    }
    joints->q[j] = s->link.q[j];
    joints->v[j] = s->link.v[j];
    joints->a[j] = s->link.a[j];
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
  memset(&x, 0, s->effects > 0 ? sizeof x : offsetof(point, link));
  x.motion = s->motion;
  if (s->effects > 0) {
    x.whole = 1;
    x.link = s->link;
    tl_effect_dynamics_begin(&p.acting, &x.motion, &x.link);
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
