/* align_fine.c: offset and rate by least squares over both joints.
 *
 * camera(t) = constant + gain * encoder(tau(t)) for each joint. Neighbouring residuals are alike (interpolation, what the
 * joint's flexibility does), so that the covariance is the sandwich of the normal matrix with the scores summed over
 * blocks of a second (Liang and Zeger 1986), not the one of white noise.
 */
#include <math.h>
#include <string.h>

#include "track/align/align.h"

enum { OFFSET, RATE, FIRST_JOINT, PARAMETERS = FIRST_JOINT + 4 };

#define BLOCK_S 1.0
#define OUTLIER 5.0      /* times the residual's RMS */
#define TIME_SCALE 100.0 /* the rate's column is of (t - middle) / 100 s */

struct sums {
  double normal[PARAMETERS][PARAMETERS], right[PARAMETERS];
  double meat[PARAMETERS][PARAMETERS]; /* of the blocks' scores */
  double square[2];
  size_t n[2];
};

/* Residual of sample i of a joint, and its slopes; -1 where it has none. */
static int row_of(const struct align_data *data, const struct clock_fit *c, int joint, size_t i,
                  double *residual, double slope[PARAMETERS]) {
  const struct series *camera = &data->camera[joint];
  const double t_s = camera->t_s[i];
  double x, v, widest;
  if (series_cubic(&data->encoder[joint], clock_to_rec(c, t_s), &x, &v, &widest) != 0 || widest > 0.1)
    return -1;
  memset(slope, 0, PARAMETERS * sizeof *slope);
  slope[OFFSET] = c->gain[joint] * v;
  slope[RATE] = c->gain[joint] * v * (t_s - c->middle_cam_s) / TIME_SCALE;
  slope[FIRST_JOINT + 2 * joint] = 1.0;
  slope[FIRST_JOINT + 2 * joint + 1] = x;
  *residual = camera->x[i] - c->constant[joint] - c->gain[joint] * x;
  return 0;
}

static void end_block(struct sums *s, double score[PARAMETERS]) {
  for (int a = 0; a < PARAMETERS; a++)
    for (int b = 0; b < PARAMETERS; b++) s->meat[a][b] += score[a] * score[b];
  memset(score, 0, PARAMETERS * sizeof *score);
}

static void add_joint(const struct align_data *data, const struct clock_fit *c, int joint, double until_s,
                      const double limit[2], struct sums *s) {
  double score[PARAMETERS] = {0}, slope[PARAMETERS], r;
  const struct series *camera = &data->camera[joint];
  const double weight =
      c->residual_rad[joint] > 0.0 ? 1.0 / (c->residual_rad[joint] * c->residual_rad[joint]) : 1.0;
  double block = -1.0;
  for (size_t i = 0; i < camera->n && camera->t_s[i] <= until_s; i++) {
    if (row_of(data, c, joint, i, &r, slope) != 0 || fabs(r) > limit[joint]) continue;
    const double now = floor(camera->t_s[i] / BLOCK_S);
    if (now != block) end_block(s, score);
    block = now;
    for (int a = 0; a < PARAMETERS; a++) {
      score[a] += weight * r * slope[a];
      s->right[a] += weight * r * slope[a];
      for (int b = 0; b < PARAMETERS; b++) s->normal[a][b] += weight * slope[a] * slope[b];
    }
    s->square[joint] += r * r;
    s->n[joint]++;
  }
  end_block(s, score);
}

/* Inverse of a symmetric positive matrix by Gauss and Jordan, scaled to ones on the diagonal. Joints without samples have no columns. */
static int invert(double m[PARAMETERS][PARAMETERS], double inverse[PARAMETERS][PARAMETERS]) {
  double scale[PARAMETERS];
  for (int a = 0; a < PARAMETERS; a++) scale[a] = m[a][a] > 0.0 ? 1.0 / sqrt(m[a][a]) : 0.0;
  for (int a = 0; a < PARAMETERS; a++)
    for (int b = 0; b < PARAMETERS; b++) {
      inverse[a][b] = a == b;
      m[a][b] = a == b && scale[a] == 0.0 ? 1.0 : m[a][b] * scale[a] * scale[b];
    }
  for (int p = 0; p < PARAMETERS; p++) {
    const double pivot = m[p][p];
    if (!(pivot > 1e-10)) return -1;
    for (int b = 0; b < PARAMETERS; b++) {
      m[p][b] /= pivot;
      inverse[p][b] /= pivot;
    }
    for (int a = 0; a < PARAMETERS; a++) {
      const double factor = m[a][p];
      if (a == p) continue;
      for (int b = 0; b < PARAMETERS; b++) {
        m[a][b] -= factor * m[p][b];
        inverse[a][b] -= factor * inverse[p][b];
      }
    }
  }
  for (int a = 0; a < PARAMETERS; a++)
    for (int b = 0; b < PARAMETERS; b++) inverse[a][b] *= scale[a] * scale[b];
  return 0;
}

static void set_uncertainty(const struct sums *s, double inverse[PARAMETERS][PARAMETERS],
                            struct clock_fit *c) {
  double sigma[2];
  for (int k = 0; k < 2; k++) {
    double sum = 0.0;
    for (int a = 0; a < PARAMETERS; a++)
      for (int b = 0; b < PARAMETERS; b++) sum += inverse[k][a] * s->meat[a][b] * inverse[b][k];
    sigma[k] = sum > 0.0 ? sqrt(sum) : 0.0;
  }
  c->offset_sigma_s = sigma[OFFSET];
  c->rate_sigma = sigma[RATE] / TIME_SCALE;
}

/* One step of Gauss and Newton with the pictures until a time; answers how far the offset moved, negative on failure. */
static double step(const struct align_data *data, struct clock_fit *c, double until_s,
                   const double limit[2]) {
  struct sums s;
  double inverse[PARAMETERS][PARAMETERS], move[PARAMETERS] = {0};
  memset(&s, 0, sizeof s);
  for (int joint = 0; joint < 2; joint++) add_joint(data, c, joint, until_s, limit, &s);
  if (s.n[0] < 100 || invert(s.normal, inverse) != 0) return -1.0;
  for (int a = 0; a < PARAMETERS; a++)
    for (int b = 0; b < PARAMETERS; b++) move[a] += inverse[a][b] * s.right[b];
  c->middle_rec_s += move[OFFSET];
  c->rate += move[RATE] / TIME_SCALE;
  for (int joint = 0; joint < 2; joint++) {
    c->constant[joint] += move[FIRST_JOINT + 2 * joint];
    c->gain[joint] += move[FIRST_JOINT + 2 * joint + 1];
    c->samples[joint] = s.n[joint];
    c->residual_rad[joint] = s.n[joint] ? sqrt(s.square[joint] / (double)s.n[joint]) : 0.0;
  }
  set_uncertainty(&s, inverse, c);
  return fabs(move[OFFSET]) + fabs(move[RATE]);
}

/* Constant and gain at the clock as it stands. */
static void start_joint(const struct align_data *data, struct clock_fit *c, int joint, double until_s) {
  const struct series *camera = &data->camera[joint];
  double n = 0.0, x1 = 0.0, y1 = 0.0, xx = 0.0, xy = 0.0, x;
  for (size_t i = 0; i < camera->n && camera->t_s[i] <= until_s; i++) {
    if (series_cubic(&data->encoder[joint], clock_to_rec(c, camera->t_s[i]), &x, NULL, NULL) != 0) continue;
    n += 1.0;
    x1 += x;
    y1 += camera->x[i];
    xx += x * x;
    xy += x * camera->x[i];
  }
  const double spread = xx - x1 * x1 / (n > 0.0 ? n : 1.0);
  c->gain[joint] = spread > 0.0 ? (xy - x1 * y1 / n) / spread : 0.0;
  c->constant[joint] = n > 0.0 ? (y1 - c->gain[joint] * x1) / n : 0.0;
}

static void move_middle(struct clock_fit *c, double cam_s) {
  c->middle_rec_s = clock_to_rec(c, cam_s);
  c->middle_cam_s = cam_s;
}

static int settle(const struct align_data *data, struct clock_fit *c, double until_s, const double limit[2]) {
  for (int pass = 0; pass < 40; pass++) {
    const double moved = step(data, c, until_s, limit);
    if (moved < 0.0) return -1;
    if (moved < 1e-9) return 0;
  }
  return -1;
}

int align_fine(const struct align_data *data, struct clock_fit *c, struct app_error *error) {
  const struct series *camera = &data->camera[0];
  const double first = camera->t_s[0], last = camera->t_s[camera->n - 1];
  double limit[2] = {1e9, 1e9}, until = first;
  int result = 0;
  /* by doubling lengths, so that a rate that is off by 1e-3 does not lose the lag */
  while (until < last && result == 0) {
    until = until > first ? first + 2.0 * (until - first) : first + 30.0;
    move_middle(c, 0.5 * (first + (until < last ? until : last)));
    for (int joint = 0; joint < 2; joint++) start_joint(data, c, joint, until);
    result = settle(data, c, until, limit);
  }
  if (result == 0) {
    for (int joint = 0; joint < 2; joint++) limit[joint] = OUTLIER * c->residual_rad[joint];
    result = settle(data, c, last, limit);
  }
  if (result != 0)
    return app_fail(error, APP_BAD_INPUT,
                    "no clock could be fitted: too little motion in common, or it is not the same motion");
  return 0;
}
