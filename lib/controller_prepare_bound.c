/* controller_prepare_bound.c: how far fixed point and tables can be from the model, by adding up what each line of
 * controller_template.h can err.
 *
 * A coefficient in Qn is rounded by 2^-(n+1), a product by half a unit of its result, a sine by SINE. Errors of factors
 * are multiplied with the largest value of what they multiply within the limits.
 */
#include <math.h>

#include "controller_prepare_internal.h"
#include "talus/drive_table.h"

#define SINE 1.6e-9                        /* of tl_sincos_fixed */
#define SUM_SINE (2.8284272 * SINE + 1e-9) /* of sin(s + a): two products; |sin| + |cos| <= sqrt 2, twice */
#define HALF_TORQUE 0x1p-22                /* half a unit of Q21, Q19, Q27, Q23, Q26, Q31 */
#define HALF_ACCELERATION 0x1p-20
#define HALF_INERTIA 0x1p-28
#define HALF_VISCOUS 0x1p-24
#define HALF_MOTOR 0x1p-27
#define UNIT 0x1p-31
#define SLOPE_FACTOR 3.1 /* step |f'| errs by step^4 sqrt(3) / 216 f'''', 3.08 times what f does */

/* a value's largest size, and its largest error */
typedef struct sized {
  double most, error;
} sized;

static sized sum(sized a, sized b) {
  return (sized){a.most + b.most, a.error + b.error};
}

/* a coefficient times a value, the product rounded */
static sized scaled(double c, double coefficient_error, sized x, double rounding) {
  return (sized){fabs(c) * x.most, fabs(c) * x.error + coefficient_error * (x.most + x.error) + rounding};
}

/* a curve in fixed point against the same in double: drive_table.c says why */
static sized curve_value(const tl_curve_f64 *c) {
  double steepest = 0.0;
  int i;

  for (i = 0; i < c->n; i++) steepest = fabs(c->knot[i].rise) > steepest ? fabs(c->knot[i].rise) : steepest;
  return (sized){1.0,
                 2.2 * UNIT + 1.5 * TL_CURVE_STEEPEST * (0x1p-25 + 0x1p-30) * (steepest > 0.0 ? 1.0 : 0.0)};
}

static sized curve_term(const tl_curve_f64 *c, double scale) {
  return c->n ? scaled(scale, HALF_TORQUE, curve_value(c), HALF_TORQUE) : (sized){0.0, 0.0};
}

/* rotor: ratio and slope with the errors of the drive's table */
static sized rotor(const tl_controller_f64 *c, double ratio_error) {
  const tl_controller_joint_f64 *j = &c->joint[1];
  double a = j->acceleration_limit, v2 = j->speed_limit_rad_s * j->speed_limit_rad_s;
  double slope_error = (SLOPE_FACTOR * ratio_error + 6.0 * UNIT) * j->slope_per_rad;
  sized slope = {j->ratio.n ? 1.5 * TL_CURVE_STEEPEST * j->slope_per_rad : 0.0, slope_error};
  sized turned = {a + slope.most * v2,
                  ratio_error * a + slope.error * v2 + (slope.most + 4.0) * HALF_ACCELERATION};

  turned.error += ratio_error * turned.most + HALF_ACCELERATION;
  return scaled(c->rotor, HALF_INERTIA, turned, HALF_TORQUE);
}

/* inertia and gravity */
static void loads(const tl_controller_f64 *c, const double ratio_error[2], sized load[2]) {
  const tl_controller_joint_f64 *k = &c->joint[0], *n = &c->joint[1];
  double v0 = k->speed_limit_rad_s, v1 = n->speed_limit_rad_s, a0 = k->acceleration_limit;
  double foot = a0 + n->acceleration_limit, both = a0 + foot, turning = 2.0 * v0 * v1 + v1 * v1;
  sized shank = {a0, 0.0}, of_foot = {foot, 0.0};
  sized knee = {both + turning, SINE * (both + turning) + 5.0 * HALF_ACCELERATION};
  sized ankle = {a0 + v0 * v0, SINE * (a0 + v0 * v0) + 3.0 * HALF_ACCELERATION};
  sized sine = {1.0, SINE}, sum_sine = {1.0, SUM_SINE};
  sized gravity = scaled(c->gravity_foot, HALF_TORQUE, sum_sine, HALF_TORQUE);

  load[0] = sum(scaled(c->shank_inertia, HALF_INERTIA, shank, HALF_TORQUE),
                scaled(c->foot_inertia, HALF_INERTIA, of_foot, HALF_TORQUE));
  load[0] = sum(load[0], scaled(c->coupling, HALF_INERTIA, knee, HALF_TORQUE));
  load[0] = sum(load[0], sum(gravity, scaled(c->gravity_shank, HALF_TORQUE, sine, HALF_TORQUE)));
  load[1] = sum(scaled(c->foot_inertia, HALF_INERTIA, of_foot, HALF_TORQUE),
                scaled(c->coupling, HALF_INERTIA, ankle, HALF_TORQUE));
  load[1] = sum(sum(load[1], gravity), rotor(c, ratio_error[1]));
}

static sized friction(const tl_controller_joint_f64 *j, sized load) {
  double slip_error =
      HALF_TORQUE * 2.0 / j->friction_gain + UNIT; /* the gain is in Q20, where it counts v < 1 / gain */
  sized speed = {j->speed_limit_rad_s, 0.0}, slip = {1.0, slip_error};
  sized level = sum(curve_term(&j->slow, j->speed_scale), curve_term(&j->position, j->position_scale));
  sized fast = curve_term(&j->fast, j->speed_scale), bias = {fabs(j->asymmetry_Nm), HALF_TORQUE};
  sized viscous = sum(scaled(j->viscous, HALF_VISCOUS, speed, HALF_TORQUE),
                      scaled(j->viscous_asymmetry, HALF_VISCOUS, speed, HALF_TORQUE));

  level.error = fast.error > level.error ? fast.error + level.error : level.error;
  level = sum(level, (sized){j->dry_Nm, HALF_TORQUE});
  level = sum(level, scaled(j->load_even, UNIT, load, HALF_TORQUE));
  bias = sum(bias, scaled(j->load_odd, UNIT, load, HALF_TORQUE));
  level.error += level.most * slip.error + HALF_TORQUE;
  bias.error += bias.most * slip.error + HALF_TORQUE;
  return sum(sum(level, bias), viscous);
}

static double motor_error(const tl_controller_f64 *c, int joint, sized load, double inverse_error) {
  const tl_controller_joint_f64 *j = &c->joint[joint];
  sized cosine = {1.0, SINE}, sum_cosine = {1.0, SUM_SINE};
  sized tilt = sum(scaled(c->tilt_shank, HALF_TORQUE, cosine, HALF_TORQUE),
                   scaled(c->tilt_foot, HALF_TORQUE, sum_cosine, HALF_TORQUE));
  sized all = sum(sum(load, friction(j, load)), sum(tilt, curve_term(&j->spring, j->spring_scale)));

  all.error += all.most * inverse_error + HALF_TORQUE;
  return fabs(j->inverse_scale) * all.error + 0.5 * UNIT * all.most + HALF_MOTOR;
}

tl_status tl_controller_error_bound(const tl_controller_f64 *c, const tl_model *model,
                                    const tl_effect *effect, int effects,
                                    const tl_controller_settings *settings, tl_controller_bound *bound) {
  tl_preparation p = {NULL, model, effect, effects, settings, NULL};
  tl_curve_knot_f64 knot[TL_DRIVE_TABLE_KNOTS];
  double ratio_error[TL_CONTROLLER_JOINTS], inverse_error[TL_CONTROLLER_JOINTS];
  tl_model true_model = *model;
  sized load[TL_CONTROLLER_JOINTS];
  int j, refused;
  tl_status status = tl_controller_true_drives(&p, model, true_model.drive, &refused);

  for (j = 0; j < TL_CONTROLLER_JOINTS && status == TL_OK; j++) {
    tl_drive_table table = {.ratio_error = UNIT, .inverse_error = UNIT};

    if (c->joint[j].inverse.n) status = tl_drive_table_make(&table, &true_model.drive[j].transmission, knot);
    ratio_error[j] = table.ratio_error;
    inverse_error[j] = table.inverse_error;
  }
  if (status != TL_OK) return status;
  loads(c, ratio_error, load);
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    bound->fixed_Nm[j] = motor_error(c, j, load[j], inverse_error[j]);
    bound->curves_Nm[j] = tl_controller_curves_error(&p, c, j);
  }
  return TL_OK;
}
