/* tl_marker_assign.c: which piece of colour is which marker: all at once, the cheapest of all ways. */
#include <math.h>

#include "marker_internal.h"

#define MISSING 1.0  /* what a marker costs that is not found */
#define FEW 6        /* candidates of a marker that are tried */
#define STRETCH 0.08 /* by which a link's length may seem to change */

typedef struct search {
  const marker_choice *choice;
  int option[TL_MARKER_MAX][FEW]; /* candidates of each marker, cheapest first */
  double cost[TL_MARKER_MAX][FEW];
  int options[TL_MARKER_MAX];
  int pick[TL_MARKER_MAX];
  double best;
} search;

/* What it costs that marker m is candidate i, by itself; MISSING or more where it is none. */
static double single_cost(const marker_choice *c, int m, int i) {
  const tl_marker_blob *blob = &c->blob[i];
  const tl_marker_memory *memory = &c->state->marker[m];
  const double dx = blob->x_px - c->predicted[m][0], dy = blob->y_px - c->predicted[m][1];
  const double apart = marker_distance(dx, dy) / c->gate[m];
  const double disc = 3.14159265358979 * c->setup->radius_px[m] * c->setup->radius_px[m];
  const double area = memory->area > 0.0 ? memory->area : disc;
  const double ratio = blob->pixels / area;
  if (blob->class_of != c->setup->color_of[m] + 1 || ratio < 0.08 || ratio > 4.0) return MISSING;
  const double size = ratio < 1.0 ? 1.0 - ratio : 1.0 - 1.0 / ratio;
  return 0.5 * apart * apart + 0.3 * size;
}

/* Keeps the FEW cheapest candidates of marker m, cheapest first. */
static void list_options(search *s, int m) {
  int n = 0;
  for (int i = 0; i < s->choice->blobs; i++) {
    const double cost = single_cost(s->choice, m, i);
    if (cost >= MISSING || (n == FEW && cost >= s->cost[m][FEW - 1])) continue;
    int at = n < FEW ? n++ : FEW - 1;
    for (; at > 0 && s->cost[m][at - 1] > cost; at--) {
      s->cost[m][at] = s->cost[m][at - 1];
      s->option[m][at] = s->option[m][at - 1];
    }
    s->cost[m][at] = cost;
    s->option[m][at] = i;
  }
  s->options[m] = n;
}

static double link_cost(const search *s, const int *pick) {
  double cost = 0.0;
  for (int k = 0; k < s->choice->setup->links; k++) {
    const int a = pick[s->choice->setup->link[k][0]], b = pick[s->choice->setup->link[k][1]];
    const double length = s->choice->state->length_px[k];
    if (a < 0 || b < 0 || length <= 0.0) continue;
    const tl_marker_blob *p = &s->choice->blob[a], *q = &s->choice->blob[b];
    const double strain = (marker_distance(p->x_px - q->x_px, p->y_px - q->y_px) / length - 1.0) / STRETCH;
    cost += strain * strain < 4.0 ? 0.5 * strain * strain : 2.0;
  }
  return cost;
}

static int taken(const int *pick, int m, int i) {
  for (int k = 0; k < m; k++)
    if (pick[k] == i) return 1;
  return 0;
}

static void try_marker(search *s, int m, int *pick, double cost) {
  if (cost >= s->best) return;
  if (m == s->choice->setup->markers) {
    cost += link_cost(s, pick);
    if (cost >= s->best) return;
    s->best = cost;
    for (int k = 0; k < m; k++) s->pick[k] = pick[k];
    return;
  }
  for (int o = 0; o < s->options[m]; o++) {
    if (taken(pick, m, s->option[m][o])) continue;
    pick[m] = s->option[m][o];
    try_marker(s, m + 1, pick, cost + s->cost[m][o]);
  }
  pick[m] = -1;
  try_marker(s, m + 1, pick, cost + MISSING);
}

void tl_marker_assign(const marker_choice *choice, int *pick) {
  search s = {.choice = choice, .best = 1e9};
  int trial[TL_MARKER_MAX];
  for (int m = 0; m < choice->setup->markers; m++) list_options(&s, m);
  try_marker(&s, 0, trial, 0.0);
  for (int m = 0; m < choice->setup->markers; m++) pick[m] = s.pick[m];
}
