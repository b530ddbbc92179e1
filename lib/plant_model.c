/* plant_model.c: the table of plants; a model's ranges and what can be identified of it. */
#include <math.h>
#include <string.h>

#include "math_inline.h"
#include "plant_internal.h"

#define STANDARD_GRAVITY_M_S2 9.81

static void inverse_of_nothing(const tl_model *m, const tl_motion *motion, double torque[TL_MAX_JOINTS]) {
  (void)m;
  (void)motion;
  (void)torque;
}

static const tl_plant_table nothing = {.facts = {.joints = 0}, .inverse = inverse_of_nothing};

#define ROW(upper, lower) &tl_plant_##lower,
const tl_plant_table *const tl_plant_rows[TL_PLANT_COUNT + 1] = {TL_PLANTS(ROW) & nothing};

static const tl_plant_table *table_of(const tl_model *m) {
  return tl_plant_table_of(m->plant);
}

const tl_facts *tl_plant_facts(tl_plant plant) {
  return &tl_plant_table_of(plant)->facts;
}

static int same_text(const char *a, const char *b) {
  while (*a && *a == *b) {
    a++;
    b++;
  }
  return *a == *b;
}

tl_status tl_plant_find(const char *name, tl_plant *plant) {
  int i;

  if (!name || !plant) return TL_ERR_ARGUMENT;
  for (i = 0; i < TL_PLANT_COUNT; i++) {
    if (!same_text(tl_plant_rows[i]->facts.name, name)) continue;
    *plant = (tl_plant)i;
    return TL_OK;
  }
  return TL_ERR_ARGUMENT;
}

tl_status tl_channel_set_of(tl_plant plant, tl_channel_set *set) {
  const tl_plant_table *t = tl_plant_table_of(plant);

  if (!set || t == &nothing) return TL_ERR_ARGUMENT;
  *set = t->facts.channels;
  return TL_OK;
}

const tl_key *tl_model_keys(tl_plant plant, int *n) {
  const tl_plant_table *t = tl_plant_table_of(plant);

  *n = t->keys;
  return t->key;
}

int tl_joint_count(const tl_model *m) {
  return table_of(m)->facts.joints;
}

const char *tl_joint_name(const tl_model *m, int joint) {
  const tl_facts *f = tl_plant_facts(m->plant);

  return joint < 0 || joint >= f->joints ? NULL : f->joint[joint];
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

/* a transmission's own call has checked its dimensions */
static tl_status check_transmission(const tl_transmission *t) {
  switch (t->kind) {
  case TL_TRANSMISSION_FIXED: return tl_is_finite(t->ratio) && t->ratio != 0.0 ? TL_OK : TL_ERR_RANGE;
  case TL_TRANSMISSION_SCREW_LINKAGE:
  case TL_TRANSMISSION_FOURIER:
  case TL_TRANSMISSION_TABLE: return TL_OK;
  }
  return TL_ERR_ARGUMENT;
}

/* what stands at one key of the model file */
static tl_status check_key(const tl_model *m, const tl_key *key) {
  const void *at = (const char *)m + key->offset;
  double x;

  if (key->kind == TL_KEY_TRANSMISSION) return check_transmission(at);
  memcpy(&x, at, sizeof x);
  if (!tl_is_finite(x)) return TL_ERR_RANGE;
  if (key->kind == TL_KEY_POSITIVE) return x > 0.0 ? TL_OK : TL_ERR_RANGE;
  return key->kind == TL_KEY_ANY || x >= 0.0 ? TL_OK : TL_ERR_RANGE;
}

tl_status tl_model_check(const tl_model *m) {
  const tl_plant_table *t;
  tl_status status = TL_OK;
  int i;

  if (!m) return TL_ERR_ARGUMENT;
  t = table_of(m);
  if (m->form != TL_FORM_LAGRANGE && m->form != TL_FORM_PAPER) return TL_ERR_ARGUMENT;
  if (m->form == TL_FORM_PAPER && !t->facts.paper_form) return TL_ERR_UNSUPPORTED;
  if (!(m->gravity_m_s2 >= 0.0) || !tl_is_finite(m->gravity_m_s2)) return TL_ERR_RANGE;
  for (i = 0; i < t->keys && status == TL_OK; i++) status = check_key(m, &t->key[i]);
  return t == &nothing ? TL_ERR_ARGUMENT : status;
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
  const tl_plant_table *t = table_of(m);
  int i;

  if (joint < 0 || joint >= t->facts.joints) return 0;
  if (t->row_index) return t->row_index(m, joint, index);
  for (i = 0; i < t->bases; i++) index[i] = i;
  return t->bases;
}
