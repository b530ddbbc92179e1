/* align_flash.c: offset and rate from a lamp that the recording switches.
 *
 * A picture shows the share of its exposure in which the lamp was on. An edge within an exposure tells its instant by that share; one
 * between two exposures only that it lies there. Both are in one likelihood, which is summed over a grid of offset and
 * rate (and exposure, where it is not known); its mean and spread are the answer.
 */
#include <math.h>
#include <stdlib.h>

#include "track/align/align.h"

#define OFFSETS 41
#define RATES 21
#define EXPOSURES 12
#define LEAST_NOISE 0.01 /* of a share */
#define LEAST_EDGES 4

struct frames {
  double *t_s, *share; /* those near an edge */
  size_t n;
};

struct box {
  double offset_s, rate; /* half widths, about the clock */
};

/* Seconds that the lamp was on until t. */
static double on_until(const struct series *edge, const double *total, double t_s) {
  size_t low = 0, high = edge->n;
  if (t_s < edge->t_s[0])
    return edge->x[0] > 0.5 ? 0.0 : t_s - edge->t_s[0]; /* on before an edge that puts it out */
  while (high - low > 1) {
    const size_t middle = (low + high) / 2;
    if (edge->t_s[middle] <= t_s)
      low = middle;
    else
      high = middle;
  }
  return total[low] + (edge->x[low] > 0.5 ? t_s - edge->t_s[low] : 0.0);
}

static double *totals(const struct series *edge) {
  double *total = malloc(edge->n * sizeof *total);
  for (size_t i = 0; total && i < edge->n; i++)
    total[i] = i == 0 ? 0.0 : total[i - 1] + (edge->x[i - 1] > 0.5 ? edge->t_s[i] - edge->t_s[i - 1] : 0.0);
  return total;
}

/* Shares 0..1: the means of the dark and the bright pictures are 0 and 1. */
static void scale_of(const struct series *lamp, double *dark, double *bright) {
  double low = lamp->x[0], high = lamp->x[0], sum[2] = {0.0, 0.0};
  size_t n[2] = {0, 0};
  for (size_t i = 0; i < lamp->n; i++) {
    if (lamp->x[i] < low) low = lamp->x[i];
    if (lamp->x[i] > high) high = lamp->x[i];
  }
  for (size_t i = 0; i < lamp->n; i++) { /* the outer quarters: shares in between are left out */
    const double place = (lamp->x[i] - low) / (high - low);
    if (place > 0.25 && place < 0.75) continue;
    sum[place > 0.5] += lamp->x[i];
    n[place > 0.5]++;
  }
  *dark = n[0] ? sum[0] / (double)n[0] : low;
  *bright = n[1] ? sum[1] / (double)n[1] : high;
}

static int near_edge(const struct series *edge, double t_s, double reach_s) {
  size_t low = 0, high = edge->n - 1;
  while (low < high) {
    const size_t middle = (low + high) / 2;
    if (edge->t_s[middle] < t_s - reach_s)
      low = middle + 1;
    else
      high = middle;
  }
  return fabs(edge->t_s[low] - t_s) <= reach_s;
}

static int gather(const struct flash_data *data, const struct clock_fit *c, double reach_s,
                  struct frames *f) {
  const struct series *lamp = &data->lamp;
  double dark, bright;
  f->t_s = malloc(lamp->n * sizeof *f->t_s);
  f->share = malloc(lamp->n * sizeof *f->share);
  f->n = 0;
  if (!f->t_s || !f->share) return -1;
  scale_of(lamp, &dark, &bright);
  for (size_t i = 0; i < lamp->n; i++) {
    if (!near_edge(&data->edge, clock_to_rec(c, lamp->t_s[i]), reach_s)) continue;
    f->t_s[f->n] = lamp->t_s[i];
    f->share[f->n++] = (lamp->x[i] - dark) / (bright - dark);
  }
  return 0;
}

/* Sum of squares at a clock; *telling counts pictures with a share between 0 and 1. */
static double misfit(const struct flash_data *data, const double *total, const struct frames *f,
                     const struct clock_fit *c, double exposure_s, size_t *telling) {
  double sum = 0.0;
  *telling = 0;
  for (size_t i = 0; i < f->n; i++) {
    const double t_s = clock_to_rec(c, f->t_s[i]);
    const double on = on_until(&data->edge, total, t_s + 0.5 * exposure_s) -
                      on_until(&data->edge, total, t_s - 0.5 * exposure_s);
    const double share = on / exposure_s, r = f->share[i] - share;
    if ((share > 0.02 && share < 0.98) || fabs(r) > 0.05) ++*telling;
    sum += r * r;
  }
  return sum;
}

static struct clock_fit at_cell(const struct clock_fit *c, const struct box *box, int i, int k) {
  struct clock_fit moved = *c;
  moved.middle_rec_s += box->offset_s * (2.0 * i / (OFFSETS - 1) - 1.0);
  moved.rate += box->rate * (2.0 * k / (RATES - 1) - 1.0);
  return moved;
}

struct grid {
  double misfit[EXPOSURES][OFFSETS][RATES];
};

/* The misfit over the grid; answers the noise of a share at the least of them. */
static double fill(const struct flash_data *data, const double *total, const struct frames *f,
                   const struct clock_fit *c, const struct box *box, double step_s, int exposures,
                   struct grid *grid) {
  double least = 1e300, noise = 0.0;
  for (int e = 0; e < exposures; e++)
    for (int i = 0; i < OFFSETS; i++)
      for (int k = 0; k < RATES; k++) {
        const struct clock_fit moved = at_cell(c, box, i, k);
        const double exposure = exposures == 1 ? data->exposure_s : step_s * (e + 0.5) / EXPOSURES;
        size_t telling;
        const double sum = misfit(data, total, f, &moved, exposure, &telling);
        grid->misfit[e][i][k] = sum;
        if (sum >= least) continue;
        least = sum;
        noise = sqrt(sum / (telling > 4 ? (double)(telling - 3) : 1.0));
      }
  return noise > LEAST_NOISE ? noise : LEAST_NOISE;
}

static double lowest(const struct grid *grid, int exposures) {
  double least = grid->misfit[0][0][0];
  for (int e = 0; e < exposures; e++)
    for (int i = 0; i < OFFSETS; i++)
      for (int k = 0; k < RATES; k++)
        if (grid->misfit[e][i][k] < least) least = grid->misfit[e][i][k];
  return least;
}

/* Mean and spread of the likelihood over the grid. */
static void conclude(const struct grid *grid, int exposures, double noise, const struct box *box,
                     struct clock_fit *c) {
  const double least = lowest(grid, exposures);
  double w = 0.0, m[2] = {0.0, 0.0}, mm[2] = {0.0, 0.0};
  for (int e = 0; e < exposures; e++)
    for (int i = 0; i < OFFSETS; i++)
      for (int k = 0; k < RATES; k++) {
        const double p = exp(-0.5 * (grid->misfit[e][i][k] - least) / (noise * noise));
        const double at[2] = {box->offset_s * (2.0 * i / (OFFSETS - 1) - 1.0),
                              box->rate * (2.0 * k / (RATES - 1) - 1.0)};
        w += p;
        for (int a = 0; a < 2; a++) {
          m[a] += p * at[a];
          mm[a] += p * at[a] * at[a];
        }
      }
  for (int a = 0; a < 2; a++) {
    m[a] /= w;
    mm[a] = sqrt(fmax(mm[a] / w - m[a] * m[a], 0.0));
  }
  c->middle_rec_s += m[0];
  c->rate += m[1];
  c->offset_sigma_s = fmax(mm[0], 0.3 * box->offset_s / (OFFSETS - 1));
  c->rate_sigma = fmax(mm[1], 0.3 * box->rate / (RATES - 1));
}

static int usable(const struct flash_data *data, const struct clock_fit *c) {
  const double first = clock_to_rec(c, data->lamp.t_s[0]),
               last = clock_to_rec(c, data->lamp.t_s[data->lamp.n - 1]);
  int edges = 0;
  for (size_t i = 0; i < data->edge.n; i++) edges += data->edge.t_s[i] > first && data->edge.t_s[i] < last;
  return edges;
}

int align_flashes(const struct flash_data *data, struct clock_fit *c, struct app_error *error) {
  const double length = data->lamp.t_s[data->lamp.n - 1] - data->lamp.t_s[0];
  const double step_s = length / (double)(data->lamp.n - 1);
  const int exposures = data->exposure_s > 0.0 ? 1 : EXPOSURES, edges = usable(data, c);
  struct box box = {0.75 * step_s, 100e-6};
  struct frames f = {NULL, NULL, 0};
  if (edges < LEAST_EDGES)
    return app_fail(error, APP_BAD_INPUT, "only %d flash edges fall into the film, expected %d or more",
                    edges, LEAST_EDGES);
  double *total = totals(&data->edge);
  struct grid *grid = malloc(sizeof *grid);
  int result = total && grid && gather(data, c, 1.3 * step_s, &f) == 0
                   ? 0
                   : app_fail(error, APP_FAILED, "out of memory");
  for (int zoom = 0; zoom < 5 && result == 0 && grid; zoom++) {
    const double noise = fill(data, total, &f, c, &box, step_s, exposures, grid);
    conclude(grid, exposures, noise, &box, c);
    box.offset_s = fmin(box.offset_s, 5.0 * c->offset_sigma_s);
    box.rate = fmin(box.rate, 5.0 * c->rate_sigma);
  }
  free(total);
  free(grid);
  free(f.t_s);
  free(f.share);
  return result;
}
