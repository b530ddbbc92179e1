/* header_given.h: what the examples in the public headers take as given, for tests/test_header_examples.py: an arm, the
 * example leg, a recording of each, and what a caller would do with the results. */
#ifndef HEADER_GIVEN_H
#define HEADER_GIVEN_H

#include "talus/experimental.h"
#include "talus/talus.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ROWS 1000
#define STEP_S 0.004

/* An arm under gravity: friction 0.2 N m, so that a torque of 0.1 N m uses half of what holds it. */
static inline tl_model given_arm(void) {
  tl_model m;

  if (tl_model_init(&m, TL_PLANT_PENDULUM) != TL_OK) exit(3);
  m.inertia_kg_m2 = 0.05;
  m.gravity_moment_kg_m = 0.2;
  m.drive[0].torque_constant_Nm_A = 0.1;
  m.drive[0].coulomb_Nm = 0.2;
  m.drive[0].viscous_Nms_rad = 0.02;
  return m;
}

static inline tl_transmission given_linkage(void) {
  const tl_screw_linkage link = {0.002, 0.090, 0.040, 0.035, 84.75};
  tl_transmission t;

  if (tl_transmission_screw_linkage(&t, &link) != TL_OK) exit(3);
  return t;
}

/* The leg of models/leg.yaml. */
static inline tl_model given_leg(void) {
  tl_model m;

  if (tl_model_init(&m, TL_PLANT_LEG) != TL_OK ||
      tl_transmission_fixed(&m.drive[0].transmission, 51.0) != TL_OK)
    exit(3);
  m.shank_length_m = 0.3615, m.shank_mass_kg = 1.624, m.shank_com_m = 0.160, m.shank_inertia_kg_m2 = 0.0420;
  m.foot_mass_kg = 0.442, m.foot_com_m = 0.055, m.foot_inertia_kg_m2 = 0.0021;
  m.ankle_motor_mass_kg = 0.4112, m.ankle_motor_com_m = 0.120;
  m.drive[0].torque_constant_Nm_A = m.drive[1].torque_constant_Nm_A = 0.1031;
  m.drive[0].coulomb_Nm = 1.2, m.drive[0].viscous_Nms_rad = 0.45;
  m.drive[1].coulomb_Nm = 0.8, m.drive[1].viscous_Nms_rad = 0.30;
  m.drive[1].transmission = given_linkage();
  m.drive[1].rotor_inertia_kg_m2 = 2.4e-6;
  return m;
}

/* The arm's motion q = 0.5 sin(t), and the torque that it takes. */
struct given_recording {
  double t_s[ROWS], q[ROWS], v[ROWS], a[ROWS], torque_Nm[ROWS];
};

static inline void given_recording(const tl_model *arm, struct given_recording *r) {
  for (int k = 0; k < ROWS; k++) {
    r->t_s[k] = k * STEP_S;
    r->q[k] = 0.5 * sin(r->t_s[k]);
    r->v[k] = 0.5 * cos(r->t_s[k]);
    r->a[k] = -r->q[k];
  }
  tl_inverse_batch(arm, ROWS, r->q, r->v, r->a, NULL, r->torque_Nm);
}

#endif
