/* plant_drive.c: a joint's drive, and what of a plant's numbers others ask for by meaning; see talus/plant.h. */
#include <string.h>

#include "plant_internal.h"

/* the number at a place of the model, `otherwise` where the plant has none (place 0) */
static double number_at(const tl_model *m, size_t place, double otherwise) {
  double x = otherwise;

  if (place) memcpy(&x, (const char *)m + place, sizeof x);
  return x;
}

static void set_number(tl_model *m, size_t place, double x) {
  if (place) memcpy((char *)m + place, &x, sizeof x);
}

/* ---- ratios ------------------------------------------------------------------ */

static double ratio_of(const tl_model *m, int joint, double q) {
  double ratio, slope;

  tl_transmission_ratio(&m->drive[joint].transmission, q, &ratio, &slope);
  return ratio;
}

double tl_torque_ratio(const tl_model *m, int joint, double q) {
  return tl_plant_facts(m->plant)->sensors.at_motor ? ratio_of(m, joint, q) : 1.0;
}

double tl_motor_torque(const tl_model *m, double torque, double ratio) {
  return tl_plant_facts(m->plant)->sensors.at_motor ? torque : torque / ratio;
}

double tl_torque_per_current(const tl_model *m, int joint, double q) {
  const tl_facts *f = tl_plant_facts(m->plant);
  double constant = m->drive[joint].torque_constant_Nm_A;

  if (!f->motor) return 1.0;
  return f->sensors.at_motor ? constant : ratio_of(m, joint, q) * constant;
}

double tl_drive_position(const tl_model *m, int joint, double q) {
  if (!tl_plant_facts(m->plant)->sensors.at_motor) return q;
  return tl_transmission_motor_angle(&m->drive[joint].transmission, q);
}

double tl_drive_ratio(const tl_model *m, int joint, double q) {
  return tl_torque_ratio(m, joint, q); /* both are the motor's, or the joint's */
}

double tl_motor_angle(const tl_model *m, int joint, double q) {
  if (!tl_plant_facts(m->plant)->motor) return q;
  return tl_transmission_motor_angle(&m->drive[joint].transmission, q);
}

double tl_motor_ratio(const tl_model *m, int joint, double q) {
  return tl_plant_facts(m->plant)->motor ? ratio_of(m, joint, q) : 1.0;
}

/* ---- constant torques ---------------------------------------------------------- */

double tl_joint_offset(const tl_model *m, int joint) {
  return number_at(m, tl_plant_table_of(m->plant)->offset[joint], 0.0);
}

void tl_clear_offsets(tl_model *m) {
  int j;

  for (j = 0; j < TL_MAX_JOINTS; j++) set_number(m, tl_plant_table_of(m->plant)->offset[j], 0.0);
}

/* ---- what turns with a motor ---------------------------------------------------- */

double tl_motor_inertia(const tl_model *m, int joint, double share, const tl_motion *motion, double *torque) {
  const tl_plant_table *t = tl_plant_table_of(m->plant);
  double ratio, slope, rotor = m->drive[joint].rotor_inertia_kg_m2;

  *torque = 0.0;
  if (!t->rotor[joint]) return share * number_at(m, t->inertia[joint], 0.0);
  tl_transmission_ratio(&m->drive[joint].transmission, motion->q[joint], &ratio, &slope);
  *torque = rotor * ratio * slope * motion->v[joint] * motion->v[joint];
  return rotor * ratio * ratio;
}

void tl_take_motor(tl_model *m, int joint, double share) {
  size_t place = tl_plant_table_of(m->plant)->inertia[joint];

  m->drive[joint].transmission.kind = TL_TRANSMISSION_FIXED;
  m->drive[joint].transmission.ratio = 1.0;
  m->drive[joint].rotor_inertia_kg_m2 = 0.0;
  set_number(m, place, number_at(m, place, 0.0) * (1.0 - share));
}

double tl_rotor_torque(const tl_model *m, const tl_motion *motion, int joint) {
  const tl_plant_table *t = tl_plant_table_of(m->plant);
  double ratio, slope;

  if (!t->rotor[joint]) return number_at(m, t->inertia[joint], 0.0) * motion->a[joint];
  tl_transmission_ratio(&m->drive[joint].transmission, motion->q[joint], &ratio, &slope);
  return m->drive[joint].rotor_inertia_kg_m2 * ratio *
         (ratio * motion->a[joint] + slope * motion->v[joint] * motion->v[joint]);
}

/* ---- gravity --------------------------------------------------------------------- */

int tl_has_gravity(const tl_model *m) {
  const tl_plant_table *t = tl_plant_table_of(m->plant);

  return t->tilt != NULL && number_at(m, t->gravity_moment, 1.0) != 0.0;
}

double tl_gravity_zero(const tl_model *m) {
  return number_at(m, tl_plant_table_of(m->plant)->gravity_zero, 0.0);
}
