/* marker_track.c: from one picture to the next: where to look, what was found, what is remembered. */
#include <math.h>
#include <string.h>

#include "marker_internal.h"

#define COAST 30     /* pictures that a hidden marker is taken to go on at its speed */
#define NEAR 4       /* pictures after which a lost marker is no longer looked for in a window of its own */
#define LEARNT 10    /* pictures after which the area's variation is known */
#define SLOWEST 0.02 /* share of a new area in the remembered one */

typedef struct frame {
  const tl_marker_setup *setup;
  const tl_marker_classes *classes;
  tl_marker_state *state;
  const tl_image *image;
  double t_s;
  tl_marker_run *run;
  size_t runs;
  tl_marker_blob blob[MARKER_CANDIDATES];
  int blobs;
  marker_choice choice;
  int pick[TL_MARKER_MAX];
} frame;

/* ---- where to look ---------------------------------------------------------- */

static double reach_of(const frame *f, int m) {
  const tl_marker_memory *memory = &f->state->marker[m];
  const double step_s = memory->known ? f->t_s - memory->t_s : 0.0;
  const double area = memory->area,
               radius = area > 0.0 ? sqrt(area / 3.14159265358979) : f->setup->radius_px[m];
  return 1.3 * radius + 6.0 + 0.6 * step_s * marker_distance(memory->vx, memory->vy);
}

/* Where marker m is expected, and how far from there it may be. */
static void predict(frame *f, int m) {
  const tl_marker_memory *memory = &f->state->marker[m];
  const double all = marker_distance(f->image->width, f->image->height);
  const double step_s = memory->lost <= COAST ? f->t_s - memory->t_s : 0.0;
  double *predicted = f->choice.predicted[m];
  if (!memory->known) {
    predicted[0] = f->setup->start_px[m][0];
    predicted[1] = f->setup->start_px[m][1];
    f->choice.gate[m] = all;
    return;
  }
  predicted[0] = memory->x + memory->vx * step_s;
  predicted[1] = memory->y + memory->vy * step_s;
  f->choice.gate[m] = 2.0 * reach_of(f, m) * (1.0 + memory->lost);
  if (f->choice.gate[m] > all) f->choice.gate[m] = all;
}

static int same(const tl_marker_blob *a, const tl_marker_blob *b) {
  return a->class_of == b->class_of && fabs(a->x_px - b->x_px) < 2.0 && fabs(a->y_px - b->y_px) < 2.0;
}

static void add_candidate(frame *f, const tl_marker_blob *blob) {
  for (int i = 0; i < f->blobs; i++)
    if (same(&f->blob[i], blob)) return;
  if (f->blobs < MARKER_CANDIDATES) f->blob[f->blobs++] = *blob;
}

static int cut(const tl_marker_blob *blob, marker_window w) {
  return blob->x0 == w.x0 || blob->y0 == w.y0 || blob->x1 == w.x1 - 1 || blob->y1 == w.y1 - 1;
}

/* Pieces of one class around a point. One that the window cuts is looked at again, with a window of its own. */
static void look_around(frame *f, int class_of, double x, double y, double half) {
  tl_marker_blob found[4], whole[1];
  const marker_window w = tl_marker_around(f->image, x, y, half);
  const int n = tl_marker_blobs(f->classes, f->image, w, 1, class_of, found, 4, f->run, f->runs);
  for (int i = 0; i < n; i++) {
    if (found[i].pixels < 4) continue;
    if (cut(&found[i], w)) {
      const marker_window wider = tl_marker_around(f->image, found[i].x_px, found[i].y_px, 1.5 * half);
      if (tl_marker_blobs(f->classes, f->image, wider, 1, class_of, whole, 1, f->run, f->runs) == 1)
        found[i] = whole[0];
    }
    add_candidate(f, &found[i]);
  }
}

static void look_near(frame *f) {
  for (int m = 0; m < f->setup->markers; m++)
    if (f->state->marker[m].known && f->state->marker[m].lost <= NEAR)
      look_around(f, f->setup->color_of[m] + 1, f->choice.predicted[m][0], f->choice.predicted[m][1],
                  reach_of(f, m) * (1.0 + 0.5 * f->state->marker[m].lost));
}

/* ---- the whole picture ----------------------------------------------------- */

/* A grid that no marker falls through: five or more points across the smallest. */
static int grid_step(const tl_marker_setup *setup) {
  double least = 500.0;
  for (int m = 0; m < setup->markers; m++)
    if (setup->radius_px[m] < least) least = setup->radius_px[m];
  const int step = (int)(0.4 * least);
  if (step < 1) return 1;
  return step > 8 ? 8 : step;
}

static void search_all(frame *f) {
  tl_marker_blob found[MARKER_CANDIDATES];
  const int step = grid_step(f->setup);
  const int n = tl_marker_find(f->classes, f->image, step, found, MARKER_CANDIDATES, f->run, f->runs);
  for (int i = 0; i < n; i++) {
    const int wide = found[i].x1 - found[i].x0, high = found[i].y1 - found[i].y0;
    const double half = 0.5 * (wide > high ? wide : high) + 2.0 * step + 2.0;
    if (half < 600.0) look_around(f, found[i].class_of, found[i].x_px, found[i].y_px, half);
  }
}

static int missing(const frame *f) {
  for (int m = 0; m < f->setup->markers; m++)
    if (f->pick[m] < 0) return 1;
  return 0;
}

static void choose(frame *f) {
  f->choice.blob = f->blob;
  f->choice.blobs = f->blobs;
  tl_marker_assign(&f->choice, f->pick);
}

/* ---- what was found ---------------------------------------------------------- */

/* Does the piece that marker m took hold another marker of its colour too? */
static int merged(const frame *f, int m) {
  const tl_marker_blob *blob = &f->blob[f->pick[m]];
  for (int k = 0; k < f->setup->markers; k++) {
    if (k == m || f->setup->color_of[k] != f->setup->color_of[m] || f->pick[k] >= 0) continue;
    if (!f->state->marker[k].known || f->state->marker[k].lost > COAST) continue;
    const double reach = 4.0 + f->setup->radius_px[k];
    const double *at = f->choice.predicted[k];
    if (at[0] > blob->x0 - reach && at[0] < blob->x1 + reach && at[1] > blob->y0 - reach &&
        at[1] < blob->y1 + reach)
      return 1;
  }
  return 0;
}

/* What the area varies by from picture to picture: half the mean square of its differences, so that a marker that slowly
 * comes nearer or turns does not count. */
static void remember_jitter(tl_marker_memory *memory, const tl_marker_sample *sample, double share) {
  if (memory->last_area > 0.0) {
    const double off = fabs(sample->area_px2 / memory->last_area - 1.0), counted = off < 0.06 ? off : 0.06;
    memory->area_jitter += share * (0.5 * counted * counted - memory->area_jitter);
  }
  memory->last_area = sample->area_px2;
}

static void remember_area(tl_marker_memory *memory, const tl_marker_sample *sample) {
  double share = 1.0 / (memory->areas + 1.0);
  const int spoilt = sample->flags & (TL_MARKER_PARTIAL | TL_MARKER_EDGE);
  remember_jitter(memory, sample, share > 0.05 ? share : 0.05);
  /* what is hidden must not become usual: it counts only until the usual is known, and only so much */
  if (memory->areas > 0 && (!spoilt || memory->areas < LEARNT)) {
    const double off = fabs(sample->area_px2 / memory->area - 1.0), counted = off < 0.06 ? off : 0.06;
    memory->area_spread += (share > 0.05 ? share : 0.05) * (counted * counted - memory->area_spread);
  }
  if (spoilt) return;
  if (share < SLOWEST) share = SLOWEST;
  memory->area += share * (sample->area_px2 - memory->area);
  memory->areas++;
}

static void remember(tl_marker_memory *memory, const tl_marker_sample *sample, double t_s) {
  if (memory->known && memory->lost <= COAST) {
    memory->vx = (sample->x_px - memory->x) / (t_s - memory->t_s);
    memory->vy = (sample->y_px - memory->y) / (t_s - memory->t_s);
  } else {
    memory->vx = memory->vy = 0.0;
  }
  memory->known = 1;
  memory->lost = 0;
  memory->x = sample->x_px;
  memory->y = sample->y_px;
  memory->t_s = t_s;
  remember_area(memory, sample);
}

/* The share of its area below which a marker is partly hidden: 0.96 in clean pictures, less where compression makes the
 * area vary by more. */
static double least_share(const tl_marker_memory *memory) {
  const double varies = 5.0 * sqrt(memory->area_spread);
  if (varies < 0.04) return 0.96;
  return varies < 0.3 ? 1.0 - varies : 0.7;
}

/* An edge that is off by pieces (compression) moves area A and centre alike: with sums over a circle, var x =
 * (r^2 / 2) var A / A^2 = spread * A / (2 pi). Noise between pixels shows there too, so the larger counts. */
static void widen(tl_marker_sample *sample, double spread) {
  const double least = spread * sample->area_px2 / (2.0 * 3.14159265358979);
  if (sample->cov_px2[0] < least) sample->cov_px2[0] = least;
  if (sample->cov_px2[2] < least) sample->cov_px2[2] = least;
}

static void look_at(frame *f, int m, tl_marker_sample *sample) {
  tl_marker_memory *memory = &f->state->marker[m];
  memset(sample, 0, sizeof *sample);
  if (f->pick[m] >= 0 && merged(f, m))
    sample->flags = TL_MARKER_MERGED;
  else if (f->pick[m] >= 0)
    *sample =
        tl_marker_measure(f->classes, f->image, &f->blob[f->pick[m]], memory->area, least_share(memory));
  if (sample->flags & TL_MARKER_SEEN) {
    if (f->state->searched && (!memory->known || memory->lost > NEAR)) sample->flags |= TL_MARKER_REACQUIRED;
    remember(memory, sample, f->t_s);
    widen(sample, memory->area_jitter);
  } else if (memory->lost < 1000000) {
    memory->lost++;
  }
}

static void remember_lengths(const tl_marker_setup *setup, tl_marker_state *state,
                             const tl_marker_sample *sample) {
  const int spoilt = TL_MARKER_PARTIAL | TL_MARKER_EDGE;
  for (int k = 0; k < setup->links; k++) {
    const tl_marker_sample *a = &sample[setup->link[k][0]], *b = &sample[setup->link[k][1]];
    if (!(a->flags & b->flags & TL_MARKER_SEEN) || (a->flags | b->flags) & spoilt) continue;
    const double length = marker_distance(a->x_px - b->x_px, a->y_px - b->y_px);
    state->length_px[k] += (state->length_px[k] > 0.0 ? 0.05 : 1.0) * (length - state->length_px[k]);
  }
}

static int late(const tl_marker_setup *setup, const tl_marker_state *state, double t_s) {
  for (int m = 0; m < setup->markers; m++)
    if (state->marker[m].known && !(t_s > state->marker[m].t_s)) return 1;
  return !(fabs(t_s) < 1e15);
}

tl_status tl_marker_track(const tl_marker_setup *setup, const tl_marker_classes *classes,
                          tl_marker_state *state, const tl_image *image, double t_s, tl_marker_sample *sample,
                          tl_marker_run *run, size_t runs) {
  frame f;
  if (!setup || !classes || !state || !sample || !run || !tl_marker_image_sound(image))
    return TL_ERR_ARGUMENT;
  if (setup->markers < 1 || setup->markers > TL_MARKER_MAX) return TL_ERR_ARGUMENT;
  if (late(setup, state, t_s)) return TL_ERR_RANGE;
  memset(&f, 0, sizeof f);
  f.setup = f.choice.setup = setup;
  f.state = state;
  f.choice.state = state;
  f.classes = classes;
  f.image = image;
  f.t_s = f.choice.t_s = t_s;
  f.run = run;
  f.runs = runs;
  for (int m = 0; m < setup->markers; m++) predict(&f, m);
  look_near(&f);
  choose(&f);
  state->searched = missing(&f);
  if (state->searched) {
    search_all(&f);
    choose(&f);
  }
  for (int m = 0; m < setup->markers; m++) look_at(&f, m, &sample[m]);
  remember_lengths(setup, state, sample);
  return TL_OK;
}
