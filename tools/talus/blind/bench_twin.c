/* bench_twin.c: runs one recording: bench_twin JOB TIMES OUT
 *
 * JOB is text (twin_read.c), TIMES binary doubles: the instants of the samples; OUT binary doubles, 20 a sample. */
#include "twin.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TWO_PI 6.28318530717958647692

enum { COLUMNS = 20 };

static double uniform(uint64_t *state) { /* splitmix64 */
  uint64_t z = (*state += 0x9E3779B97F4A7C15u);

  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return ((double)((z ^ (z >> 31)) >> 11) + 0.5) / 9007199254740992.0;
}

double twin_normal(uint64_t *state) {
  double radius = sqrt(-2.0 * log(uniform(state)));

  return radius * cos(TWO_PI * uniform(state));
}

/* What the motor's encoder shows, `ahead_s` into the step that was just made. */
double twin_shown_angle(const twin_bench *b, const twin_state *s, int joint, double ahead_s) {
  const twin_joint *j = &b->joint[joint];
  int at = joint == KNEE ? DRIVE_K : DRIVE_A;
  double motor, ratio, bend;

  twin_transmission(b, joint, s->q[at] + ahead_s * s->v[at], &motor, &ratio, &bend);
  return j->enc_a != 0.0 ? motor + j->enc_a * (sin(j->enc_n * motor + j->enc_p) - sin(j->enc_p)) : motor;
}

static double multisine(const twin_bench *b, const double *size, const double *phase, double t) {
  double sum = 0.0, fade = b->settle_s > 0.0 ? (t + b->settle_s) / 1.5 : 1.0;
  int k;

  for (k = 0; k < (int)b->harmonics; k++) sum += size[k] * sin(TWO_PI * b->base_hz * (k + 1) * t + phase[k]);
  if (fade >= 1.0) return sum;
  return fade <= 0.0 ? 0.0 : sum * fade * fade * fade * (10.0 - 15.0 * fade + 6.0 * fade * fade);
}

/* Slope at a point, by its neighbours. */
static double slope(const twin_bench *b, const double *value, int at) {
  int left = at > 0 ? at - 1 : at, right = at + 1 < (int)b->points ? at + 1 : at;

  return (value[right] - value[left]) / (b->point_s[right] - b->point_s[left]);
}

/* A series of points, joined by straight lines, or by cubics with the slopes of the points (Catmull and Rom, 1974). */
static double ramp(const twin_bench *b, const double *value, double t) {
  int low = 0, high = (int)b->points - 1;
  double width, x;

  if (t <= b->point_s[0]) return value[0];
  if (t >= b->point_s[high]) return value[high];
  while (high - low > 1) {
    int middle = (low + high) / 2;
    if (t < b->point_s[middle])
      high = middle;
    else
      low = middle;
  }
  width = b->point_s[high] - b->point_s[low];
  x = (t - b->point_s[low]) / width;
  if (b->smooth > 0.5)
    return value[low] + (value[high] - value[low]) * x * x * (3.0 - 2.0 * x) +
           width * x * (1.0 - x) * ((1.0 - x) * slope(b, value, low) - x * slope(b, value, high));
  return value[low] + (value[high] - value[low]) * (t - b->point_s[low]) / width;
}

static double wanted(const twin_bench *b, int joint, double t) {
  if (b->points > 0.0) return ramp(b, joint == KNEE ? b->point_knee : b->point_ankle, t);
  return multisine(b, joint == KNEE ? b->knee_a : b->ankle_a, joint == KNEE ? b->knee_p : b->ankle_p, t);
}

/* The position control, once a millisecond: PD on the motor's encoder, no feedforward, a limit on the current. */
void twin_control(const twin_bench *b, twin_state *s, double t) {
  const double tick = 1e-3;
  int joint;

  for (joint = 0; joint < twin_joints(b); joint++) {
    const twin_joint *j = &b->joint[joint];
    double w = b->ref_filter > 0.0 ? b->ref_filter : 0.0, target = wanted(b, joint, t), ratio = b->ratio,
           before, now;
    double inertia = joint == KNEE ? 0.18 : 0.006, omega = TWO_PI * j->bandwidth, angle, rate, aim, aim_v, i;

    before = s->reference[joint];
    if (w > 0.0) { /* rounds the corners of the ramps */
      s->reference_v[joint] += tick * (w * w * (target - before) - 2.0 * w * s->reference_v[joint]);
      now = before + tick * s->reference_v[joint];
    } else {
      now = target;
    }
    s->reference[joint] = now;
    aim = joint == KNEE ? b->ratio * now : twin_linkage_known(b, now, &ratio);
    aim_v = (now - before) / tick * ratio;
    angle = twin_shown_angle(b, s, joint, 0.0);
    rate = (angle - s->last_angle[joint]) / tick;
    s->last_angle[joint] = angle;
    if (joint == ANKLE) inertia += b->ima * ratio * ratio;
    if (j->control_inertia > 0.0) inertia = j->control_inertia;
    i = inertia / (ratio * ratio) * (omega * omega * (aim - angle) + 2.0 * j->zeta * omega * (aim_v - rate));
    i /= j->torque_constant;
    s->current[joint] = fmax(-j->current_limit, fmin(j->current_limit, i));
  }
}

/* One row, `ahead` into a step: positions at its begin, velocities at its end and accelerations in it are given. */
static void sample(const twin_bench *b, const twin_state *s, double ahead, double t, double *row) {
  const double left = b->step_s - ahead;
  double motor, ratio, bend, v, a;

  row[0] = t;
  row[1] = twin_shown_angle(b, s, KNEE, ahead);
  row[2] = twin_shown_angle(b, s, ANKLE, ahead);
  row[3] = twin_joint_angle(s->q, ANKLE) + ahead * twin_joint_angle(s->v, ANKLE);
  row[4] = s->q[SHANK] + ahead * s->v[SHANK];
  row[5] = s->q[FOOT] + ahead * s->v[FOOT];
  row[8] = b->ratio * (s->v[DRIVE_K] - left * s->a[DRIVE_K]);
  row[9] = b->ratio * s->a[DRIVE_K];
  a = s->a[DRIVE_A];
  v = s->v[DRIVE_A] - left * a;
  twin_transmission(b, ANKLE, s->q[DRIVE_A] + ahead * s->v[DRIVE_A], &motor, &ratio, &bend);
  row[10] = ratio * v;
  row[11] = ratio * a + bend * v * v;
  row[12] = b->ratio * (s->q[DRIVE_K] + ahead * s->v[DRIVE_K]);
  row[13] = motor;
  row[14] = s->load[KNEE];
  row[15] = s->load[ANKLE];
  row[16] = twin_energy(b, t, s);
  row[17] = s->work_in - s->work_lost;
  row[18] = s->v[SHANK] - left * s->a[SHANK];
  row[19] = s->a[SHANK];
}

/* The sensor's own lag follows the current. */
static void show_current(const twin_bench *b, twin_state *s) {
  int joint;

  for (joint = 0; joint < JOINTS; joint++) {
    double lag = b->joint[joint].lag;
    if (lag > 0.0)
      s->shown[joint] += (1.0 - exp(-b->step_s / lag)) * (s->current[joint] - s->shown[joint]);
    else
      s->shown[joint] = s->current[joint];
  }
}

static int run(const twin_bench *b, const double *times, size_t n, double *rows) {
  long ticks = lround(1e-3 / b->step_s), k = 0;
  size_t at = 0, current[JOINTS] = {0, 0};
  double begin = -floor(b->settle_s * 1e3) * 1e-3, range = b->range > 0.0 ? b->range : 1.5;
  twin_state s;
  int joint;

  memset(&s, 0, sizeof s);
  s.random = (uint64_t)b->seed;
  while (at < n || current[KNEE] < n || current[ANKLE] < n) {
    double t = begin + (double)k * b->step_s, end = t + b->step_s;
    twin_state before;
    if (k % ticks == 0) twin_control(b, &s, t);
    show_current(b, &s);
    before = s;
    twin_step(b, &s, t);
    for (joint = 0; joint < JOINTS; joint++) /* a current that is shown late is one from earlier */
      for (; current[joint] < n && times[current[joint]] - b->joint[joint].delay < end; current[joint]++)
        rows[current[joint] * COLUMNS + 6 + (size_t)joint] = s.shown[joint];
    if (at < n && times[at] < end) {
      twin_state now = s;
      memcpy(now.q, before.q, sizeof s.q); /* positions move with the new velocities */
      for (; at < n && times[at] < end; at++) sample(b, &now, times[at] - t, times[at], rows + at * COLUMNS);
    }
    for (joint = 0; joint < twin_joints(b); joint++)
      if (!(fabs(twin_joint_angle(s.q, joint)) < range)) return -1;
    k++;
  }
  return 0;
}

/* The whole file; its length in bytes, or 0. */
static double *read_times(const char *path, size_t *n) {
  FILE *file = fopen(path, "rb");
  double *times = NULL;
  long size;

  *n = 0;
  if (!file) return NULL;
  if (fseek(file, 0, SEEK_END) == 0 && (size = ftell(file)) > 0) {
    rewind(file);
    times = malloc((size_t)size);
    if (times) *n = fread(times, sizeof(double), (size_t)size / sizeof(double), file);
  }
  (void)fclose(file);
  return times;
}

static int write_rows(const char *path, const double *rows, size_t n) {
  FILE *file = fopen(path, "wb");
  size_t written;

  if (!file) return -1;
  written = fwrite(rows, sizeof(double), n * COLUMNS, file);
  return fclose(file) == 0 && written == n * COLUMNS ? 0 : -1;
}

int main(int count, char **argument) {
  static twin_bench bench; /* large: it holds every point of a series */
  double *times, *rows;
  size_t n;
  int status = 2;

  if (count != 4 || twin_read(&bench, argument[1]) != 0) return 2;
  times = read_times(argument[2], &n);
  rows = calloc(n + 1, COLUMNS * sizeof(double));
  if (times && rows && n > 0) {
    status = run(&bench, times, n, rows);
    if (status != 0) fprintf(stderr, "bench_twin: the leg left its range\n");
    status = status == 0 && write_rows(argument[3], rows, n) != 0 ? 2 : -status;
  }
  free(times);
  free(rows);
  return status;
}
