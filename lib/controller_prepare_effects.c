/* controller_prepare_effects.c: effects in the form that a tick takes.
 *
 * Each kind says its form (tl_effect_fast). Laws of the speed, of the angle or of the motor's torque become curves, sampled
 * from the one law that tl_effect_law holds; those that are linear in what a tick has at hand become numbers.
 */
#include <math.h>
#include <string.h>

#include "controller_prepare_internal.h"

#define SLOPE_PART 1e-3 /* of a step, for the slope at a knot */

/* ---- curves ------------------------------------------------------------------------- */

/* a sum of effects of one form at one joint over one coordinate */
typedef struct sampled {
  const tl_preparation *p;
  int joint;
  tl_effect_fast form;
} sampled;

static double value_at(const sampled *f, double x) {
  tl_effect_instant now = {.q = x, .v = x, .slip = 1.0, .motor_Nm = x, .ratio = 1.0};
  double sum = 0.0, torque, friction;
  int i;

  for (i = 0; i < f->p->effects; i++) {
    const tl_effect *e = &f->p->effect[i];
    if (e->joint != f->joint || e->kind->fast != f->form) continue;
    tl_effect_law(e, &now, &torque, &friction);
    sum += torque + friction;
  }
  return sum;
}

/* knots of the true values; one-sided slopes at the ends, of second order */
static void sample(const sampled *f, double low, double high, tl_curve_knot_f64 *knot) {
  int n = TL_CONTROLLER_CURVE_KNOTS, i;
  double step = (high - low) / (double)(n - 1), h = SLOPE_PART * step;

  for (i = 0; i < n; i++) {
    double x = low + (double)i * step, here = value_at(f, x), slope;

    if (i == 0)
      slope = (4.0 * value_at(f, x + h) - value_at(f, x + 2.0 * h) - 3.0 * here) / (2.0 * h);
    else if (i == n - 1)
      slope = (3.0 * here - 4.0 * value_at(f, x - h) + value_at(f, x - 2.0 * h)) / (2.0 * h);
    else
      slope = (value_at(f, x + h) - value_at(f, x - h)) / (2.0 * h);
    knot[i] = (tl_curve_knot_f64){here, slope * step};
  }
}

static tl_status finish(double scale, double low, double high, tl_curve_knot_f64 *knot, tl_curve_f64 *curve) {
  int n = TL_CONTROLLER_CURVE_KNOTS;

  tl_curve_divide(knot, n, scale);
  return tl_curve_init_f64(curve, knot, n, low, (high - low) / (double)(n - 1));
}

static tl_status add_curve(tl_preparation *p, const sampled *f, double low, double high, double factor,
                           tl_curve_f64 *curve, double *scale) {
  tl_curve_knot_f64 *knot = p->knot;
  double most;

  sample(f, low, high, knot);
  most = tl_curve_bound(knot, TL_CONTROLLER_CURVE_KNOTS);
  if (most == 0.0) return TL_OK;
  *scale = factor * most;
  p->knot += TL_CONTROLLER_CURVE_KNOTS;
  return finish(most, low, high, knot, curve);
}

/* the speed below which a law bends, as Stribeck's does; a sixteenth of the range without one */
static double slow_speed(const tl_preparation *p, int joint, double limit) {
  double slow = limit / 16.0;
  int i;

  for (i = 0; i < p->effects; i++)
    if (p->effect[i].joint == joint && p->effect[i].kind->bends_below) {
      double bend = 4.0 * p->effect[i].value[p->effect[i].kind->bends_below];
      slow = bend < slow ? bend : slow;
    }
  return slow;
}

/* friction beside Coulomb's over speed in two curves with one scale: a fine one near standstill */
static tl_status add_speed_curves(tl_preparation *p, int joint) {
  const tl_controller_joint_settings *s = &p->settings->joint[joint];
  tl_controller_joint_f64 *to = &p->c->joint[joint];
  sampled f = {p, joint, TL_FAST_SPEED};
  double slow = slow_speed(p, joint, s->speed_limit_rad_s), most, beyond;
  tl_curve_knot_f64 *knot = p->knot;
  int n = TL_CONTROLLER_CURVE_KNOTS;
  tl_status status;

  sample(&f, 0.0, slow, knot);
  sample(&f, slow, s->speed_limit_rad_s, knot + n);
  most = tl_curve_bound(knot, n);
  beyond = tl_curve_bound(knot + n, n);
  most = beyond > most ? beyond : most;
  if (most == 0.0) return TL_OK;
  to->slow_rad_s = slow;
  to->speed_scale = s->friction_share * most;
  p->knot += 2 * n;
  status = finish(most, 0.0, slow, knot, &to->slow);
  return status == TL_OK ? finish(most, slow, s->speed_limit_rad_s, knot + n, &to->fast) : status;
}

static tl_status add_curves(tl_preparation *p, int joint) {
  const tl_controller_joint_settings *s = &p->settings->joint[joint];
  tl_controller_joint_f64 *to = &p->c->joint[joint];
  sampled spring = {p, joint, TL_FAST_SPRING}, position = {p, joint, TL_FAST_POSITION},
          droop = {p, joint, TL_FAST_DROOP};
  double low = s->low_rad - s->slack_rad, high = s->high_rad + s->slack_rad;
  tl_status status = add_speed_curves(p, joint);

  if (status == TL_OK) status = add_curve(p, &spring, low, high, 1.0, &to->spring, &to->spring_scale);
  if (status == TL_OK)
    status = add_curve(p, &position, low, high, s->friction_share, &to->position, &to->position_scale);
  if (status == TL_OK)
    status = add_curve(p, &droop, 0.0, to->torque_limit_Nm, 1.0, &to->droop, &to->droop_scale);
  return status;
}

#define POINTS 16

/* largest difference of a curve from what it stands for */
static double curve_error(const sampled *f, const tl_curve_f64 *curve, double most) {
  double worst = 0.0, slope;
  int i;

  for (i = 0; curve->n && i <= (curve->n - 1) * POINTS; i++) {
    double x = curve->first + (double)i / ((double)POINTS * curve->per_step);
    double error = fabs(most * tl_curve_at_f64(curve, x, &slope) - value_at(f, x));
    worst = error > worst ? error : worst;
  }
  return worst;
}

double tl_controller_curves_error(const tl_preparation *p, const tl_controller_f64 *c, int joint) {
  const tl_controller_joint_f64 *j = &c->joint[joint];
  double share = p->settings->joint[joint].friction_share;
  sampled speed = {p, joint, TL_FAST_SPEED}, spring = {p, joint, TL_FAST_SPRING},
          position = {p, joint, TL_FAST_POSITION};
  double slow, fast, per_share = share > 0.0 ? 1.0 / share : 0.0;

  slow = curve_error(&speed, &j->slow, j->speed_scale * per_share);
  fast = curve_error(&speed, &j->fast, j->speed_scale * per_share);
  return fabs(j->inverse_scale) *
         (share * (slow > fast ? slow : fast) +
          share * curve_error(&position, &j->position, j->position_scale * per_share) +
          curve_error(&spring, &j->spring, j->spring_scale));
}

/* ---- numbers ------------------------------------------------------------------------ */

static void add_joint_numbers(tl_controller_joint_f64 *to, const tl_effect_numbers *from, double share) {
  to->asymmetry_Nm += share * from->asymmetry_Nm;
  to->viscous_asymmetry += share * from->asymmetry_Nms_rad;
  to->load_even += 0.5 * share * (from->driving + from->back_driving);
  to->load_odd += 0.5 * share * (from->driving - from->back_driving);
  to->offset_Nm += from->offset_Nm;
  if (from->asymmetry_Nm != 0.0 || from->asymmetry_Nms_rad != 0.0) to->uses |= TL_CONTROLLER_USES_ASYMMETRY;
  if (from->driving != 0.0 || from->back_driving != 0.0) to->uses |= TL_CONTROLLER_USES_LOAD;
  if (from->offset_Nm != 0.0) to->uses |= TL_CONTROLLER_USES_OFFSET;
}

static tl_status add_numbers(tl_preparation *p, const tl_effect *e) {
  tl_controller_f64 *c = p->c;
  tl_effect_numbers numbers;
  tl_status status;
  int j;

  memset(&numbers, 0, sizeof numbers);
  status = e->kind->numbers(e, &numbers);
  if (status != TL_OK) return status;
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++)
    if (tl_effect_at(e, j)) add_joint_numbers(&c->joint[j], &numbers, p->settings->joint[j].friction_share);
  c->tilt_shank += numbers.tilt_rad * c->gravity_shank;
  c->tilt_foot += numbers.tilt_rad * c->gravity_foot;
  c->tilted |= numbers.tilt_rad != 0.0;
  return TL_OK;
}

/* ---- all ---------------------------------------------------------------------------- */

tl_status tl_controller_true_drives(const tl_preparation *p, const tl_model *model,
                                    tl_drive drive[TL_CONTROLLER_JOINTS], int *refused) {
  int i, j;

  for (i = 0; i < p->effects; i++) {
    const tl_effect *e = &p->effect[i];
    tl_status status =
        !e->kind || e->kind->fast == TL_FAST_NONE ? TL_ERR_UNSUPPORTED : tl_effect_check(e, model);
    *refused = i;
    if (status != TL_OK) return status;
  }
  *refused = -1;
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    tl_effect_change change = tl_effects_change(p->effect, p->effects, j);
    tl_status status =
        tl_effect_change_linkage(&change, &model->drive[j].transmission, &drive[j].transmission);

    if (status != TL_OK) return status;
  }
  return TL_OK;
}

/* With droop and offset the current's limit is reached at less torque: halve the interval until it is found */
static void keep_current(tl_preparation *p, int joint) {
  tl_controller_joint_f64 *to = &p->c->joint[joint];
  sampled droop = {p, joint, TL_FAST_DROOP};
  double most = p->settings->joint[joint].current_limit_A / to->amperes_per_Nm - fabs(to->offset_Nm);
  double low = 0.0, high = to->torque_limit_Nm;
  int i;

  if (high + fabs(value_at(&droop, high)) <= most) return;
  for (i = 0; i < 60; i++) {
    double middle = 0.5 * (low + high);
    if (middle + fabs(value_at(&droop, middle)) <= most)
      low = middle;
    else
      high = middle;
  }
  /* the curve of the droop is not the droop: a little less */
  to->torque_limit_Nm = 0.999 * low;
}

tl_status tl_controller_add_effects(tl_preparation *p, int *refused) {
  int i, j;

  for (i = 0; i < p->effects; i++) {
    tl_status status = TL_OK;

    if (p->effect[i].kind->fast == TL_FAST_NUMBERS) status = add_numbers(p, &p->effect[i]);
    *refused = i;
    if (status != TL_OK) return status;
  }
  *refused = -1;
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    tl_status status;

    keep_current(p, j);
    status = p->c->joint[j].torque_limit_Nm > 0.0 ? add_curves(p, j) : TL_ERR_RANGE;
    if (status != TL_OK) return status;
  }
  return TL_OK;
}
