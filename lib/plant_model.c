/* plant_model.c: a model's ranges, its joints and what can be identified of it. */
#include <math.h>
#include <string.h>

#include "plant_internal.h"
#include "transmission_internal.h"

#define STANDARD_GRAVITY_M_S2 9.81

static const tl_plant_table nothing = {{0, 0}, 0, NULL, 0, NULL, 0, NULL, NULL};

static const tl_plant_table *table_of(const tl_model *m) {
  switch (m->plant) {
  case TL_PLANT_LEG: return &tl_leg_table;
  case TL_PLANT_PENDULUM: return &tl_pendulum_table;
  case TL_PLANT_SLIDER: return &tl_slider_table;
  }
  return &nothing;
}

int tl_joint_count(const tl_model *m) {
  return table_of(m)->joints;
}

const char *tl_joint_name(const tl_model *m, int joint) {
  const tl_plant_table *t = table_of(m);

  return joint < 0 || joint >= t->joints ? NULL : t->joint[joint];
}

tl_status tl_model_init(tl_model *m, tl_plant plant) {
  tl_model made = {.plant = plant, .form = TL_FORM_LAGRANGE, .gravity_m_s2 = STANDARD_GRAVITY_M_S2};
  int j;

  if (!m || table_of(&made) == &nothing) return TL_ERR_ARGUMENT;
  for (j = 0; j < TL_MAX_JOINTS; j++) {
    tl_status status = tl_transmission_fixed(&made.drive[j].transmission, 1.0);
    if (status != TL_OK) return status;
  }
  *m = made;
  return TL_OK;
}

/* ---- ranges ------------------------------------------------------------ */

static int all_positive(const double *x, int n) {
  int i;

  for (i = 0; i < n; i++)
    if (!(x[i] > 0.0) || !tl_is_finite(x[i])) return 0;
  return 1;
}

static int none_negative(const double *x, int n) {
  int i;

  for (i = 0; i < n; i++)
    if (!(x[i] >= 0.0) || !tl_is_finite(x[i])) return 0;
  return 1;
}

static int friction_is_sound(const tl_drive *d) {
  double friction[2] = {d->coulomb_Nm, d->viscous_Nms_rad};

  return none_negative(friction, 2);
}

/* a drive with motor and transmission; a transmission's own call has checked its dimensions */
static tl_status check_drive(const tl_drive *d) {
  switch (d->transmission.kind) {
  case TL_TRANSMISSION_FIXED:
    if (!tl_is_finite(d->transmission.ratio) || d->transmission.ratio == 0.0) return TL_ERR_RANGE;
    break;
  case TL_TRANSMISSION_SCREW_LINKAGE:
  case TL_TRANSMISSION_FOURIER:
  case TL_TRANSMISSION_TABLE: break;
  default: return TL_ERR_ARGUMENT;
  }
  return all_positive(&d->torque_constant_Nm_A, 1) && friction_is_sound(d) ? TL_OK : TL_ERR_RANGE;
}

static tl_status check_leg(const tl_model *m) {
  double positive[] = {
      m->shank_length_m,     m->shank_mass_kg,       m->shank_inertia_kg_m2,         m->foot_mass_kg,
      m->foot_inertia_kg_m2, m->ankle_motor_mass_kg, m->drive[1].rotor_inertia_kg_m2};
  double not_negative[] = {m->shank_com_m, m->foot_com_m, m->ankle_motor_com_m};
  tl_status status = check_drive(&m->drive[0]);

  if (status == TL_OK) status = check_drive(&m->drive[1]);
  if (status != TL_OK) return status;
  return all_positive(positive, 7) && none_negative(not_negative, 3) ? TL_OK : TL_ERR_RANGE;
}

static tl_status check_pendulum(const tl_model *m) {
  tl_status status = check_drive(&m->drive[0]);

  if (status != TL_OK) return status;
  return all_positive(&m->inertia_kg_m2, 1) && none_negative(&m->gravity_moment_kg_m, 1) &&
                 tl_is_finite(m->gravity_zero_rad) && tl_is_finite(m->torque_offset_Nm)
             ? TL_OK
             : TL_ERR_RANGE;
}

static tl_status check_slider(const tl_model *m) {
  return all_positive(&m->mass_kg, 1) && friction_is_sound(&m->drive[0]) && tl_is_finite(m->force_offset_N)
             ? TL_OK
             : TL_ERR_RANGE;
}

tl_status tl_model_check(const tl_model *m) {
  if (!m) return TL_ERR_ARGUMENT;
  if (m->form != TL_FORM_LAGRANGE && m->form != TL_FORM_PAPER) return TL_ERR_ARGUMENT;
  if (m->form == TL_FORM_PAPER && m->plant != TL_PLANT_LEG) return TL_ERR_UNSUPPORTED;
  if (!none_negative(&m->gravity_m_s2, 1)) return TL_ERR_RANGE;
  switch (m->plant) {
  case TL_PLANT_LEG: return check_leg(m);
  case TL_PLANT_PENDULUM: return check_pendulum(m);
  case TL_PLANT_SLIDER: return check_slider(m);
  }
  return TL_ERR_ARGUMENT;
}

/* ---- what is identified ------------------------------------------------ */

const tl_parameter *tl_parameters(const tl_model *m, int *n) {
  const tl_plant_table *t = table_of(m);

  *n = t->parameters;
  return t->parameter;
}

void tl_parameters_get(const tl_model *m, double *p) {
  const tl_plant_table *t = table_of(m);
  int i;

  for (i = 0; i < t->parameters; i++) memcpy(&p[i], (const char *)m + t->parameter[i].offset, sizeof p[i]);
}

void tl_parameters_set(tl_model *m, const double *p) {
  const tl_plant_table *t = table_of(m);
  int i;

  for (i = 0; i < t->parameters; i++) memcpy((char *)m + t->parameter[i].offset, &p[i], sizeof p[i]);
}

int tl_base_count(const tl_model *m) {
  return table_of(m)->bases;
}

const char *tl_base_name(const tl_model *m, int base) {
  const tl_plant_table *t = table_of(m);

  return base < 0 || base >= t->bases ? NULL : t->base[base];
}

void tl_base_values(const tl_model *m, double *base) {
  double p[TL_MAX_PARAMETERS];

  tl_parameters_get(m, p);
  tl_base_at(m, p, base);
}

void tl_base_at(const tl_model *m, const double *p, double *base) {
  const tl_plant_table *t = table_of(m);

  if (t->base_at) t->base_at(m, p, base);
}

void tl_base_jacobian(const tl_model *m, double *jacobian) {
  const tl_plant_table *t = table_of(m);
  int i;

  for (i = 0; i < t->bases * t->parameters; i++) jacobian[i] = 0.0;
  if (t->base_jacobian) t->base_jacobian(m, jacobian);
}

int tl_row_index(const tl_model *m, int joint, int index[TL_MAX_ROW]) {
  /* the ankle's frictions come last in the knee's row: only the paper's form has them there */
  static const int knee[] = {0, 1, 2, 3, 5, 6, 7, 8}, ankle[] = {2, 3, 4, 7, 8};
  int n = tl_base_count(m), i;

  if (joint < 0 || joint >= tl_joint_count(m)) return 0;
  if (m->plant == TL_PLANT_LEG) n = joint ? 5 : m->form == TL_FORM_PAPER ? 8 : 6;
  for (i = 0; i < n; i++) index[i] = m->plant != TL_PLANT_LEG ? i : joint ? ankle[i] : knee[i];
  return n;
}
