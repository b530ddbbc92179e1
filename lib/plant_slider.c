/* plant_slider.c: a mass on a straight guide, force = mass a + friction + offset. */
#include "plant_internal.h"

/* base and physical parameters are the same here */
enum { MASS, COULOMB, VISCOUS, OFFSET, PARAMETERS };

void tl_slider_inverse(const tl_model *m, const tl_motion *motion, double torque[TL_MAX_JOINTS]) {
  torque[0] = m->mass_kg * motion->a[0] + m->drive[0].coulomb_Nm * motion->slip[0] +
              m->drive[0].viscous_Nms_rad * motion->v[0] + m->force_offset_N;
}

void tl_slider_regressor(const tl_motion *motion, double *row) {
  row[MASS] = motion->a[0];
  row[COULOMB] = motion->slip[0];
  row[VISCOUS] = motion->v[0];
  row[OFFSET] = 1.0;
}

static const tl_parameter parameter[PARAMETERS] = {
    [MASS] = {"mass_kg", offsetof(tl_model, mass_kg), 0.0, 0, 1},
    [COULOMB] = {"coulomb_N", TL_DRIVE_OFFSET(0, coulomb_Nm), 0.0, 0, 0},
    [VISCOUS] = {"viscous_Ns_m", TL_DRIVE_OFFSET(0, viscous_Nms_rad), 0.0, 0, 0},
    [OFFSET] = {"force_offset_N", offsetof(tl_model, force_offset_N), TL_UNBOUNDED, 0, 0},
};

static const char *const base_name[PARAMETERS] = {"mass", "coulomb", "viscous", "force_offset"};

static void base_at(const tl_model *m, const double *p, double *base) {
  int i;

  (void)m;
  for (i = 0; i < PARAMETERS; i++) base[i] = p[i];
}

static void base_jacobian(const tl_model *m, double *jacobian) {
  int i;

  (void)m;
  for (i = 0; i < PARAMETERS; i++) jacobian[i * PARAMETERS + i] = 1.0;
}

const tl_plant_table tl_slider_table = {
    {"slider", 0}, 1, parameter, PARAMETERS, base_name, PARAMETERS, base_at, base_jacobian,
};
