/* kinematics_window.c: how a joint's angle is read, from its own data; see talus/kinematics.h.
 *
 * The window: a polynomial of order 5 answers in its second derivative as a function of
 * frequency times length alone: 1 % short at 0.53, 10 % at 1.0, 3 dB at 1.36. So a length of one over the
 * score's low-pass is the longest that keeps the scored band, and the longest is the least noisy.
 */
#include <math.h>

#include "talus/kinematics.h"

#define ORDER 5
#define VELOCITY_ORDER 2
#define VELOCITY_LENGTH 0.32 /* the same 10 % for the first derivative of an order-2 window */
#define LEAST_ROWS 7
#define VELOCITY_LEAST_ROWS 5
#define SURE 5.0         /* standard deviations of the quick velocity that tell motion from noise */
#define SMALL_SPEED 0.01 /* of the speed's 95th percentile, where the score names no standstill */
#define RESOLUTION_QUANTILE 0.001
#define SQRT_12 3.4641016151377544
#define MAD_TO_SIGMA 1.4826022185056018 /* median absolute deviation of a normal variable */

tl_segment tl_sample_place(const tl_segment *segment, size_t count, int k) {
  size_t total = 0, i, at, rows;

  for (i = 0; i < count; i++) total += segment[i].end - segment[i].begin;
  at = total / TL_SAMPLE_PLACES * (size_t)k;
  for (i = 0; i + 1 < count && at >= segment[i].end - segment[i].begin; i++)
    at -= segment[i].end - segment[i].begin;
  rows = segment[i].end - segment[i].begin;
  if (rows <= TL_SAMPLE_ROWS) return segment[i];
  at = segment[i].begin + (at + TL_SAMPLE_ROWS > rows ? rows - TL_SAMPLE_ROWS : at);
  return (tl_segment){at, at + TL_SAMPLE_ROWS};
}

size_t tl_kinematics_window_workspace(size_t n) {
  return tl_reconstruct_workspace(n) + 2 * n;
}

/* whole window of 2 k + 1 rows, its edges between samples so that jitter does not move them */
static tl_window rows_window(int order, double half_rows, double step_s) {
  tl_window w = {order, (2.0 * half_rows + 0.5) * step_s};
  return w;
}

static tl_window default_window(int angle, double lowpass_hz, double step_s) {
  double length = (angle ? 1.0 : VELOCITY_LENGTH) / (lowpass_hz * step_s), half, least;

  half = floor(0.5 * length + 0.5 - 1e-9);
  least = 0.5 * ((angle ? LEAST_ROWS : VELOCITY_LEAST_ROWS) - 1);
  return rows_window(angle ? ORDER : VELOCITY_ORDER, half > least ? half : least, step_s);
}

/* k-th smallest of x by selection; n >= 1 */
static double quantile(double *x, size_t n, double share) {
  size_t gap, i, k = (size_t)(share * (double)(n - 1));

  /* Shell's sort: short, in place, and n is a few thousand */
  for (gap = n / 2; gap > 0; gap = gap == 2 ? 1 : gap * 5 / 11)
    for (i = gap; i < n; i++) {
      double lifted = x[i];
      size_t j = i;
      for (; j >= gap && x[j - gap] > lifted; j -= gap) x[j] = x[j - gap];
      x[j] = lifted;
    }
  return x[k];
}

/* the smallest change that the recording shows: its resolution */
static double resolution(const double *x, size_t n, double *work) {
  size_t i, count = 0;

  for (i = 1; i < n; i++)
    if (x[i] != x[i - 1]) work[count++] = fabs(x[i] - x[i - 1]);
  return count ? quantile(work, count, RESOLUTION_QUANTILE) : 0.0;
}

/* standard deviation of what the window leaves of x, robust against the few places where it
 * bends too sharply, freed from the share that the window itself takes in */
static tl_status residual_noise(const tl_window *w, const tl_block *s, const double *x, double step_s,
                                double *work, size_t work_n, double *out) {
  double *fit = work, *rest = work + 2 * s->n, own;
  size_t i, rows = (size_t)(w->length_s / step_s) | 1u, half;
  tl_status status = tl_reconstruct(w, s->t_s, x, s->n, fit, NULL, NULL, rest, work_n - 2 * s->n);

  if (status != TL_OK) return status;
  for (i = 0; i < s->n; i++) fit[i] = fabs(x[i] - fit[i]);
  *out = MAD_TO_SIGMA * quantile(fit, s->n, 0.5);
  /* leverage of the centre sample: its own weight in the value */
  rows = rows > s->n ? s->n | 1u : rows;
  half = rows / 2;
  if (rows > s->n) return TL_OK;
  status = tl_window_weights(s->t_s, rows, s->t_s[half], w->order, rest, rest + 3 * rows);
  own = status == TL_OK ? rest[3 * rows + half] : 0.0;
  *out /= own < 0.99 ? sqrt(1.0 - own) : 1.0;
  return TL_OK;
}

/* standard deviation of the quick velocity of 2 k + 1 rows for unit noise */
static double quick_gain(int half_rows, double step_s) {
  double sum = 0.0;
  int k;

  for (k = 1; k <= half_rows; k++) sum += 2.0 * k * k;
  return 1.0 / (step_s * sqrt(sum));
}

/* the shortest quick window whose noise stays clear of what counts as standstill */
static void choose_quick(tl_sensing *s, const tl_score_settings *score, double wanted, double noise,
                         double step_s) {
  int half = 1, most = (int)(0.25 / (score->lowpass_hz * step_s));

  while (half < most && SURE * noise * quick_gain(half, step_s) > wanted) half++;
  s->quick = rows_window(2, half, step_s);
  s->standstill = SURE * noise * quick_gain(half, step_s);
  if (s->standstill < score->standstill) s->standstill = score->standstill;
}

/* 95th percentile of the joint's speed by differences of the recorded angle */
static double usual_speed(const tl_block *s, const double *x, double ratio, double *work) {
  size_t i;

  for (i = 1; i < s->n; i++) work[i - 1] = fabs((x[i] - x[i - 1]) / (s->t_s[i] - s->t_s[i - 1]) / ratio);
  return quantile(work, s->n - 1, 0.95);
}

/* d motor / d joint at the middle of the sample */
static double typical_ratio(const tl_model *m, int joint, const double *x, size_t n) {
  const tl_transmission *t = &m->drive[joint].transmission;
  double sum = 0.0, ratio, slope;
  size_t i;

  if (!tl_plant_facts(m->plant)->sensors.at_motor) return 1.0;
  for (i = 0; i < n; i++) sum += x[i];
  tl_transmission_ratio(t, tl_transmission_joint_angle(t, sum / (double)n), &ratio, &slope);
  return fabs(ratio);
}

tl_status tl_kinematics_window(const tl_model *m, const tl_layout *layout, int joint,
                               const tl_score_settings *score, double step_s, const tl_block *sample,
                               double *work, size_t work_n, tl_sensing *out) {
  int angle = layout->position[joint] != TL_CHANNEL_COUNT;
  const double *x = sample->channel[angle ? layout->position[joint] : layout->velocity[joint]];
  double ratio, least, wanted;
  tl_status status;

  if (!x || !(step_s > 0.0)) return TL_ERR_ARGUMENT;
  if (sample->n < 30) return TL_ERR_TOO_SHORT;
  if (work_n < tl_kinematics_window_workspace(sample->n)) return TL_ERR_WORKSPACE;
  out->across = 0;
  out->window = default_window(angle, score->lowpass_hz, step_s);
  status = residual_noise(&out->window, sample, x, step_s, work, work_n, &out->noise);
  if (status != TL_OK) return status;
  out->step = resolution(x, sample->n, work);
  least = out->step / SQRT_12;
  if (out->noise < least) out->noise = least;
  ratio = typical_ratio(m, joint, x, sample->n);
  if (!angle) {
    /* what the window leaves of a velocity is as much motion as noise; its resolution is sure */
    out->quick = out->window;
    out->standstill = score->standstill > SURE * least ? score->standstill : SURE * least;
    return TL_OK;
  }
  wanted = score->standstill > 0.0 ? score->standstill : SMALL_SPEED * usual_speed(sample, x, ratio, work);
  choose_quick(out, score, wanted, out->noise / ratio, step_s);
  return TL_OK;
}
