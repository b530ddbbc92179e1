/* effect_prepared.c: what all columns of a segment share, made once; see effect_columns.h. */
#include "effect_columns.h"

#include <math.h>
#include <string.h>

#define SMALL 1e-5 /* [rad], [rad/s]: step of slopes */
#define MOUNT 6

enum { LOAD_READY = 1, SLOPES_READY = 2, MOUNT_READY = 4, MOTOR_READY = 8 };

size_t tl_effect_prepared_memory(int joints, size_t n) {
  size_t j = (size_t)joints;

  return (3 * j + 3 * j * j + (joints > 1 ? MOUNT : 0) + 6) * n +
         tl_reconstruct_workspace(n < TL_WINDOW_MAX_SAMPLES ? n : TL_WINDOW_MAX_SAMPLES);
}

static double *take(double **memory, size_t n) {
  double *first = *memory;

  *memory += n;
  return first;
}

void tl_effect_prepare(tl_effect_prepared *p, const tl_effect_segment *s, double *memory) {
  int joints = tl_joint_count(s->model), j, other, k;

  memset(p, 0, sizeof *p);
  p->segment = s;
  p->bare = tl_effect_bare_model(s->model);
  for (j = 0; j < joints; j++) {
    p->load_Nm[j] = take(&memory, s->n);
    p->motor_Nm[j] = take(&memory, s->n);
    p->ratio[j] = take(&memory, s->n);
    for (other = 0; other < joints; other++)
      for (k = 0; k < 3; k++) p->slope[j][other][k] = take(&memory, s->n);
  }
  for (k = 0; k < MOUNT && joints > 1; k++) p->mount[k] = take(&memory, s->n);
  p->work = memory;
}

const double *tl_columns_load(tl_effect_prepared *p, int joint) {
  int joints = tl_joint_count(p->segment->model), j;
  double torque[TL_MAX_JOINTS];
  tl_motion now;
  size_t i;

  for (i = 0; i < p->segment->n && !(p->ready & LOAD_READY); i++) {
    tl_columns_motion(p->segment, i, &now);
    tl_inverse(&p->bare, &now, torque);
    for (j = 0; j < joints; j++) p->load_Nm[j][i] = torque[j];
  }
  p->ready |= LOAD_READY;
  return p->load_Nm[joint];
}

const double *tl_columns_motor_torque(tl_effect_prepared *p, int joint) {
  static const double unit[TL_MAX_JOINTS] = {1.0, 1.0};
  const tl_effect_segment *s = p->segment;
  double torque[TL_MAX_JOINTS], ratio[TL_MAX_JOINTS];
  int joints = tl_joint_count(s->model), j;
  tl_motion now;
  size_t i;

  if (p->ready & MOTOR_READY) return p->motor_Nm[joint];
  p->ready |= MOTOR_READY;
  for (i = 0; i < s->n; i++) {
    tl_columns_motion(s, i, &now);
    tl_inverse(s->model, &now, torque);
    tl_joint_torque(s->model, now.q, unit, ratio);
    for (j = 0; j < joints; j++) {
      p->motor_Nm[j][i] = torque[j];
      p->ratio[j][i] = ratio[j];
    }
  }
  for (j = 0; j < joints; j++) tl_columns_bridge(s, j, p->motor_Nm[j]);
  return p->motor_Nm[joint];
}

/* slope k (by angle, speed, acceleration) of every joint's bare torque by a joint, at one row */
static void slope_at(tl_effect_prepared *p, const tl_motion *now, int moved, int k, size_t i) {
  double step = k < 2 ? SMALL : 1.0, more[TL_MAX_JOINTS], less[TL_MAX_JOINTS];
  tl_motion beside = *now;
  double *x = k == 0 ? &beside.q[moved] : k == 1 ? &beside.v[moved] : &beside.a[moved], here = *x;
  int j;

  *x = here + step;
  tl_inverse(&p->bare, &beside, more);
  *x = here - step;
  tl_inverse(&p->bare, &beside, less);
  for (j = 0; j < tl_joint_count(&p->bare); j++)
    p->slope[j][moved][k][i] = (more[j] - less[j]) * (0.5 / step);
}

double *const *tl_columns_slopes(tl_effect_prepared *p, int moved, int joint) {
  int joints = tl_joint_count(p->segment->model), j, k;
  tl_motion now;
  size_t i;

  for (i = 0; i < p->segment->n && !(p->ready & SLOPES_READY); i++) {
    tl_columns_motion(p->segment, i, &now);
    for (j = 0; j < joints; j++)
      for (k = 0; k < 3; k++) slope_at(p, &now, j, k, i);
  }
  p->ready |= SLOPES_READY;
  return p->slope[joint][moved];
}

/* moments of shank and foot, each times sine and cosine of its absolute angle, by gravity's torque on them */
static void moments_at(const tl_effect_prepared *p, const tl_model *weightless, const tl_motion *now,
                       size_t i) {
  double torque[TL_MAX_JOINTS];
  tl_motion still;

  memset(&still, 0, sizeof still);
  memcpy(still.q, now->q, sizeof still.q);
  tl_inverse(weightless, &still, torque);
  p->mount[4][i] = torque[1];
  p->mount[2][i] = torque[0] - torque[1];
  p->mount[5][i] = tl_effect_tilt_of(weightless, now, 1);
  p->mount[3][i] = tl_effect_tilt_of(weightless, now, 0) - p->mount[5][i];
}

/* of both links' inertia on the mount, to the front or (`up`) upwards */
static double force_on_mount(double *const *mount, const tl_motion *now, int up, size_t i) {
  double v = now->v[0], foot_v = v + now->v[1], a = now->a[0], foot_a = a + now->a[1];
  double side = up ? 1.0 : -1.0; /* a link's end goes on a circle: r sin q to the front, -r cos q upwards */

  return mount[2 + !up][i] * a + side * mount[2 + up][i] * v * v + mount[4 + !up][i] * foot_a +
         side * mount[4 + up][i] * foot_v * foot_v;
}

double *const *tl_columns_mount(tl_effect_prepared *p) {
  tl_model weightless = p->bare;
  tl_motion now;
  size_t i;
  int up;

  weightless.gravity_m_s2 = 1.0;
  for (i = 0; i < p->segment->n && !(p->ready & MOUNT_READY); i++) {
    tl_columns_motion(p->segment, i, &now);
    moments_at(p, &weightless, &now, i);
    for (up = 0; up < 2; up++) p->mount[up][i] = force_on_mount(p->mount, &now, up, i);
  }
  p->ready |= MOUNT_READY;
  return p->mount;
}
