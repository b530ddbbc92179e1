/* Random states inside the limits: float and fixed point against double, and double against tl_inverse with effects.
 *
 *     controller_states MODEL.yaml COUNT SEED
 *
 * Prints for each joint the largest differences over the torque limit: double from the model (where friction does not
 * fade), float from double, fixed from double at the same quantised state, and the bound proven for fixed from the model; last how
 * often fixed point saturated. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "controller_pair.h"
#include "talus/random.h"

enum { MODEL, FLOAT, FIXED, KINDS };

static void draw(const struct trio *t, uint64_t seed, uint64_t i, tl_controller_frame_f64 *f) {
  tl_controller_frame_q31 q;
  double u[6];
  int j;

  for (j = 0; j < 3; j++) tl_random_uniform2(seed, (uint64_t)j, i, u + 2 * j);
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    const tl_controller_joint_f64 *to = &t->f64.joint[j];

    f->angle_rad[j] = to->low_rad + (to->high_rad - to->low_rad) * u[j];
    f->speed_rad_s[j] = to->speed_limit_rad_s * (2.0 * u[2 + j] - 1.0);
    f->acceleration[j] = to->acceleration_limit * (2.0 * u[4 + j] - 1.0);
  }
  f->count = 0;
  frame_to_q31(f, &q);
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    f->angle_rad[j] = tl_fixed_to_double(q.angle_rad[j], TL_Q_ANGLE);
    f->speed_rad_s[j] = tl_fixed_to_double(q.speed_rad_s[j], TL_Q_SPEED);
    f->acceleration[j] = tl_fixed_to_double(q.acceleration[j], TL_Q_ACCELERATION);
  }
}

static void of_model(const struct trio *t, const tl_controller_frame_f64 *f, double torque[2]) {
  tl_motion m = {{f->angle_rad[0], f->angle_rad[1]},
                 {f->speed_rad_s[0], f->speed_rad_s[1]},
                 {f->acceleration[0], f->acceleration[1]},
                 {0.0, 0.0}};
  int j;

  tl_slip_from_velocity(&t->file.model, &m);
  tl_inverse(&t->file.model, &m, torque);
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++)
    torque[j] += tl_effects_torque(t->file.effect, t->file.effects, &t->file.model, &m, j, 0.0, 0.0, NULL);
}

static void note(double *worst, double difference) {
  if (!(fabs(difference) <= *worst)) *worst = fabs(difference);
}

static void compare(const struct trio *t, const tl_controller_frame_f64 *f, double worst[KINDS][2],
                    uint32_t *saturated) {
  tl_controller_frame_f32 f32;
  tl_controller_frame_q31 q31;
  tl_controller_parts_f64 parts;
  tl_controller_parts_f32 parts_f32;
  tl_controller_parts_q31 parts_q31;
  double torque[2], model[2];
  float torque_f32[2];
  int32_t torque_q31[2];
  int j;

  frame_to_f32(f, &f32);
  frame_to_q31(f, &q31);
  of_model(t, f, model);
  tl_controller_torque_f64(&t->f64, f, torque, &parts);
  tl_controller_torque_f32(&t->f32, &f32, torque_f32, &parts_f32);
  tl_controller_torque_q31(&t->q31, &q31, torque_q31, &parts_q31, saturated);
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    double limit = t->f64.joint[j].torque_limit_Nm;

    if (fabs(f->speed_rad_s[j]) >= t->settings.joint[j].friction_fade_rad_s)
      note(&worst[MODEL][j], (torque[j] - model[j]) / limit);
    note(&worst[FLOAT][j], ((double)torque_f32[j] - torque[j]) / limit);
    note(&worst[FIXED][j], (tl_fixed_to_double(torque_q31[j], TL_Q_MOTOR_TORQUE) - torque[j]) / limit);
  }
}

int main(int argc, char **argv) {
  static struct trio t;
  struct app_error error;
  tl_controller_bound bound;
  tl_controller_frame_f64 f;
  double worst[KINDS][2] = {{0.0}};
  uint32_t saturated = 0;
  uint64_t i, n, seed;
  int j;

  if (argc != 4) return 2;
  if (trio_read(&t, argv[1], 20.0, &error) != 0) return app_exit(&error);
  n = strtoull(argv[2], NULL, 10);
  seed = strtoull(argv[3], NULL, 10);
  for (i = 0; i < n; i++) {
    draw(&t, seed, i, &f);
    compare(&t, &f, worst, &saturated);
  }
  if (tl_controller_error_bound(&t.f64, &t.file.model, t.file.effect, t.file.effects, &t.settings, &bound) !=
      TL_OK)
    return 1;
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++)
    printf("%s %.3g %.3g %.3g %.3g\n", tl_joint_name(&t.file.model, j), worst[MODEL][j], worst[FLOAT][j],
           worst[FIXED][j], bound.fixed_Nm[j] / t.f64.joint[j].torque_limit_Nm);
  printf("saturated %u\n", (unsigned)saturated);
  return 0;
}
