/* controller_prepare.c: the plain model and the limits of a controller, see talus/experimental/controller_prepare.h. */
#include "talus/experimental/controller_prepare.h"

#include <math.h>
#include <string.h>

#include "controller_prepare_internal.h"
#include "talus/drive_table.h"
#include "talus/math.h"

#define MARGIN 1.01 /* of a rate over the least that is needed: rounding never eats the last tick */
#define FIRST_LINE                                                                                           \
  1.4142135624 /* where the first line below power / speed touches, over the corner's speed */

static int is_positive(double x) {
  return x > 0.0 && x - x == 0.0;
}

/* ---- settings -------------------------------------------------------------------- */

static double torque_limit(const tl_controller_joint_settings *s, const tl_drive *d) {
  double of_current = d->torque_constant_Nm_A * s->current_limit_A;

  return s->torque_limit_Nm < of_current ? s->torque_limit_Nm : of_current;
}

/* the largest |ratio| over the joint's range, from its ends and 63 points between */
static double largest_ratio(const tl_transmission *t, const tl_controller_joint_settings *s) {
  double most = 0.0, ratio, slope;
  int i;

  for (i = 0; i <= 64; i++) {
    tl_transmission_ratio(t, s->low_rad + (s->high_rad - s->low_rad) * (double)i / 64.0, &ratio, &slope);
    most = fabs(ratio) > most ? fabs(ratio) : most;
  }
  return MARGIN * most;
}

double tl_controller_least_rate(const tl_controller_settings *settings, const tl_model *model, int joint) {
  const tl_controller_joint_settings *s = &settings->joint[joint];
  double torque = torque_limit(s, &model->drive[joint]);
  double ratio = largest_ratio(&model->drive[joint].transmission, s);
  double decay = torque / ((double)settings->decay_ticks * settings->tick_s);
  double power = torque * torque / (FIRST_LINE * FIRST_LINE * s->power_limit_W) * ratio *
                 s->acceleration_limit_rad_s2 * (double)(settings->stale_ticks + 1);

  return MARGIN * (decay > power ? decay : power);
}

void tl_controller_defaults(const tl_model *model, tl_controller_settings *settings) {
  static const double stop_rad[TL_CONTROLLER_JOINTS] = {2.0, TL_JOINT_RANGE_RAD};
  int j;

  *settings =
      (tl_controller_settings){.tick_s = 1e-3, .stale_ticks = 4, .decay_ticks = 15, .recover_ticks = 50};
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    settings->joint[j] = (tl_controller_joint_settings){.current_limit_A = 20.0,
                                                        .power_limit_W = 200.0,
                                                        .low_rad = -stop_rad[j],
                                                        .high_rad = stop_rad[j],
                                                        .fade_rad = 0.05,
                                                        .speed_limit_rad_s = 12.0,
                                                        .acceleration_limit_rad_s2 = 150.0,
                                                        .slack_rad = 0.01,
                                                        .friction_fade_rad_s = 0.05,
                                                        .friction_share = 1.0,
                                                        .frozen_rad_s = 0.5};
    settings->joint[j].torque_limit_Nm = 20.0 * model->drive[j].torque_constant_Nm_A;
    settings->joint[j].rate_Nm_s = 1.25 * tl_controller_least_rate(settings, model, j);
  }
}

static int ticks_are_sound(const tl_controller_settings *s) {
  return is_positive(s->tick_s) && s->stale_ticks >= 0 && s->decay_ticks >= 2 && s->recover_ticks >= 1 &&
         s->recover_ticks <= TL_CONTROLLER_MOST_TICKS && s->stale_ticks < 100 && s->decay_ticks <= 100 &&
         (double)(s->stale_ticks + s->decay_ticks) * s->tick_s <= TL_CONTROLLER_DECAY_S * (1.0 + 1e-9);
}

static int joint_is_sound(const tl_controller_joint_settings *s, const tl_transmission *t) {
  double range = t->kind == TL_TRANSMISSION_FIXED ? TL_PI : TL_JOINT_RANGE_RAD;

  return is_positive(s->current_limit_A) && is_positive(s->torque_limit_Nm) && is_positive(s->rate_Nm_s) &&
         is_positive(s->power_limit_W) && is_positive(s->fade_rad) && is_positive(s->speed_limit_rad_s) &&
         is_positive(s->acceleration_limit_rad_s2) && is_positive(s->slack_rad) &&
         is_positive(s->friction_fade_rad_s) && is_positive(s->frozen_rad_s) && s->friction_share >= 0.0 &&
         s->friction_share <= 1.0 && s->low_rad >= -range && s->high_rad <= range &&
         s->high_rad > s->low_rad && s->fade_rad <= 1.0 && s->speed_limit_rad_s <= 32.0 &&
         s->acceleration_limit_rad_s2 <= 1024.0;
}

static tl_status check_settings(const tl_controller_settings *s, const tl_model *model) {
  int j;

  if (!ticks_are_sound(s)) return TL_ERR_RANGE;
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    if (!joint_is_sound(&s->joint[j], &model->drive[j].transmission)) return TL_ERR_RANGE;
    if (!(s->joint[j].rate_Nm_s >= tl_controller_least_rate(s, model, j))) return TL_ERR_RANGE;
  }
  return TL_OK;
}

/* ---- the plain model ------------------------------------------------------------- */

/* Lines that touch power / speed from below at speeds a factor of 2 apart; on the corner's side they pass the torque
 * limit. Motor speed is at most the joint's times the largest ratio. */
static void put_power(tl_controller_joint_f64 *to, double power_W, double ratio) {
  double touch = FIRST_LINE * power_W / to->torque_limit_Nm;
  int i;

  for (i = 0; i < TL_POWER_LINES; i++) {
    to->power_Nm[i] = 2.0 * power_W / touch;
    to->power_slope[i] = power_W / (touch * touch) * ratio;
    touch *= 2.0;
  }
}

static void put_limits(tl_preparation *p, int joint) {
  const tl_controller_joint_settings *s = &p->settings->joint[joint];
  tl_controller_joint_f64 *to = &p->c->joint[joint];
  double tick_s = p->settings->tick_s, ratio = largest_ratio(&p->model->drive[joint].transmission, s);

  to->torque_limit_Nm = torque_limit(s, &p->model->drive[joint]);
  to->rate_Nm = s->rate_Nm_s * tick_s;
  put_power(to, s->power_limit_W, ratio);
  to->low_rad = s->low_rad;
  to->high_rad = s->high_rad;
  to->fade_gain = 1.0 / s->fade_rad;
  to->middle_rad = 0.5 * (s->low_rad + s->high_rad);
  to->reach_rad = 0.5 * (s->high_rad - s->low_rad) + s->slack_rad;
  to->speed_limit_rad_s = s->speed_limit_rad_s;
  to->acceleration_limit = s->acceleration_limit_rad_s2;
  to->angle_step_rad = s->speed_limit_rad_s * tick_s;
  to->angle_slack_rad = s->slack_rad;
  to->speed_step_rad_s = s->acceleration_limit_rad_s2 * tick_s;
  to->frozen_rad_s = s->frozen_rad_s;
}

static void put_friction(tl_preparation *p, int joint) {
  const tl_controller_joint_settings *s = &p->settings->joint[joint];
  const tl_drive *d = &p->model->drive[joint];
  tl_controller_joint_f64 *to = &p->c->joint[joint];

  to->friction_gain = 1.0 / s->friction_fade_rad_s;
  to->dry_Nm = s->friction_share * d->coulomb_Nm;
  to->viscous = s->friction_share * d->viscous_Nms_rad;
  to->amperes_per_Nm = 1.0 / d->torque_constant_Nm_A;
}

/* ratio and 1 / ratio as curves, or as numbers */
static tl_status put_drive(tl_preparation *p, int joint, const tl_transmission *t) {
  tl_controller_joint_f64 *to = &p->c->joint[joint];
  tl_curve_knot_f64 knot[TL_DRIVE_TABLE_KNOTS];
  tl_drive_table table;
  tl_status status;
  double ratio = t->ratio, slope;
  int n;

  if (t->kind == TL_TRANSMISSION_FIXED) {
    to->inverse_scale = 1.0 / ratio;
    to->side = ratio > 0.0 ? 1 : -1;
    if (joint == 1) p->c->rotor = p->model->drive[1].rotor_inertia_kg_m2 * ratio * ratio;
    return TL_OK;
  }
  status = tl_drive_table_make(&table, t, knot);
  if (status != TL_OK) return status;
  n = table.ratio.n;
  memcpy(p->knot, table.ratio.knot, (size_t)(2 * n) * sizeof *knot); /* 1 / ratio follows the ratio */
  to->ratio = table.ratio;
  to->ratio.knot = p->knot;
  to->inverse = table.inverse;
  to->inverse.knot = p->knot + n;
  p->knot += 2 * n;
  to->inverse_scale = table.inverse_scale;
  to->slope_per_rad = 1.0 / table.step_rad;
  tl_transmission_ratio(t, 0.0, &ratio, &slope);
  to->side = ratio > 0.0 ? 1 : -1;
  if (joint == 1)
    p->c->rotor = p->model->drive[1].rotor_inertia_kg_m2 * table.ratio_scale * table.ratio_scale;
  return TL_OK;
}

static void put_rigid_leg(tl_controller_f64 *c, const tl_model *m) {
  double base[TL_MAX_BASE], foot_at_ankle = m->foot_mass_kg * m->shank_length_m;

  tl_base_values(m, base);
  c->shank_inertia = base[TL_LEG_SHANK_INERTIA] + foot_at_ankle * m->shank_length_m;
  c->foot_inertia = base[TL_LEG_FOOT_INERTIA];
  c->coupling = base[TL_LEG_FOOT_MOMENT] * m->shank_length_m;
  c->gravity_shank = (base[TL_LEG_SHANK_MOMENT] + foot_at_ankle) * m->gravity_m_s2;
  c->gravity_foot = base[TL_LEG_FOOT_MOMENT] * m->gravity_m_s2;
}

static tl_status put_joints(tl_preparation *p) {
  int j;

  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    tl_status status = put_drive(p, j, &p->model->drive[j].transmission);

    if (status != TL_OK) return status;
    put_limits(p, j);
    put_friction(p, j);
  }
  return TL_OK;
}

tl_status tl_controller_prepare(tl_controller_f64 *c, const tl_model *model, const tl_effect *effect,
                                int effects, const tl_controller_settings *settings, tl_curve_knot_f64 *knot,
                                int *refused) {
  tl_controller_f64 made;
  tl_model true_model;
  tl_preparation p = {&made, &true_model, effect, effects, settings, knot};
  tl_status status;

  if (!c || !model || !settings || !knot || !refused || (effects && !effect)) return TL_ERR_ARGUMENT;
  *refused = -1;
  if (tl_joint_count(model) != TL_CONTROLLER_JOINTS || model->form != TL_FORM_LAGRANGE)
    return TL_ERR_UNSUPPORTED;
  status = tl_model_check(model);
  true_model = *model;
  if (status == TL_OK) status = tl_controller_true_drives(&p, model, true_model.drive, refused);
  if (status == TL_OK) status = check_settings(settings, &true_model);
  if (status != TL_OK) return status;
  memset(&made, 0, sizeof made);
  made.per_level = 1.0 / (double)settings->decay_ticks;
  made.stale_ticks = settings->stale_ticks;
  made.decay_ticks = settings->decay_ticks;
  made.recover_ticks = settings->recover_ticks;
  put_rigid_leg(&made, model);
  status = put_joints(&p);
  if (status == TL_OK) status = tl_controller_add_effects(&p, refused);
  if (status == TL_OK) *c = made;
  return status;
}
