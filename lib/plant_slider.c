/* plant_slider.c: a mass on a straight guide, force = mass a + friction + offset. */
#include "math_inline.h"
#include "plant_internal.h"

/* base and physical parameters are the same here */
enum { MASS, COULOMB, VISCOUS, OFFSET, PARAMETERS };

static void inverse(const tl_model *m, const tl_motion *motion, double torque[TL_MAX_JOINTS]) {
  torque[0] = m->mass_kg * motion->a[0] + m->drive[0].coulomb_Nm * motion->slip[0] +
              m->drive[0].viscous_Nms_rad * motion->v[0] + m->force_offset_N;
}

static void inertia_matrix(const tl_model *m, const double q[TL_MAX_JOINTS], double *matrix) {
  (void)q;
  matrix[0] = m->mass_kg;
}

static void regressor(const tl_model *m, const tl_motion *motion, double *row, double known[TL_MAX_JOINTS]) {
  (void)m;
  (void)known;
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

static const char *const base_name[PARAMETERS] = {
    [MASS] = "mass", [COULOMB] = "coulomb", [VISCOUS] = "viscous", [OFFSET] = "force_offset"};

static void base_at(const tl_model *m, const double *p, double *base) {
  int i;

  (void)m;
  for (i = 0; i < PARAMETERS; i++) base[i] = p[i];
}

static void base_jacobian(const tl_model *m, double *jacobian) {
  int i;

  (void)m;
  for (i = 0; i < PARAMETERS; i++) jacobian[tl_entry(PARAMETERS, i, i)] = 1.0;
}

static const tl_key key[] = {
    {"mass_kg", offsetof(tl_model, mass_kg), TL_KEY_POSITIVE, 0},
    {"friction.coulomb_N", TL_DRIVE_OFFSET(0, coulomb_Nm), TL_KEY_NOT_NEGATIVE, 0},
    {"friction.viscous_Ns_m", TL_DRIVE_OFFSET(0, viscous_Nms_rad), TL_KEY_NOT_NEGATIVE, 0},
    {"force_offset_N", offsetof(tl_model, force_offset_N), TL_KEY_ANY, 0},
};

#define BIT(name) TL_CHANNEL_BIT(TL_CHANNEL_##name)
#define REQUIRED (BIT(TIME) | BIT(SLIDER) | BIT(SLIDER_FORCE))

const tl_plant_table tl_plant_slider = {
    .facts = {.name = "slider",
              .joints = 1,
              .joint = {"slider"},
              .coordinate_unit = "m",
              .torque_unit = "N",
              .torque_name = "force",
              .prediction = {"slider_force_N"},
              .place = {TL_PLACE_SINGLE},
              .channels = {.required = REQUIRED, .known = REQUIRED | BIT(VALID) | BIT(SLIDER_COMMAND)},
              .sensors = {.position = {TL_CHANNEL_SLIDER, TL_NO_CHANNEL},
                          .velocity = TL_NO_CHANNELS,
                          .current = TL_NO_CHANNELS,
                          .torque = {TL_CHANNEL_SLIDER_FORCE, TL_NO_CHANNEL},
                          .temperature = TL_NO_CHANNELS,
                          .encoder = TL_NO_CHANNELS,
                          .camera = TL_NO_CHANNELS,
                          .command = {TL_CHANNEL_SLIDER_COMMAND, TL_NO_CHANNEL},
                          .load = TL_NO_CHANNEL},
              .bench = {.multisine_amplitude = {0.1},
                        .ramp_amplitude = {0.1},
                        .ramp_speed = {0.3 * 0.2, 0.09 * 0.2, 0.03 * 0.2},
                        .ramp_acceleration = 1.0,
                        .speed = 2.0,
                        .acceleration = 20.0,
                        .drive_step = {1e-6}}},
    .key = key,
    .keys = sizeof key / sizeof key[0],
    .parameter = parameter,
    .parameters = PARAMETERS,
    .base = base_name,
    .bases = PARAMETERS,
    .base_at = base_at,
    .base_jacobian = base_jacobian,
    .inverse = inverse,
    .inertia_matrix = inertia_matrix,
    .regressor = regressor,
    .offset = {offsetof(tl_model, force_offset_N)},
    .inertia = {offsetof(tl_model, mass_kg)},
};
