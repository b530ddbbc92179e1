/* kinematics_stops.c: see lib/kinematics_stops.h.
 *
 * A stop is cut where the velocity changes sign or stays below standstill for some rows.
 * The rows about it are told apart carefully: the quick velocity at the last moving row
 * already looks one row ahead, across the stop, so the instant of rest is taken from a
 * parabola through the three rows before.
 */
#include "kinematics_stops.h"

#include <math.h>

#include "talus/signal.h"

#define QUIET_ROWS 3 /* more rows than this below standstill are a stop even without a change of sign */
#define PHASE_ROWS 4 /* a slip phase with fewer rows belongs to the stop around it */
#define PARABOLA 3   /* rows before the stop that tell when it begins */

#define PHASE_ORDER_ROOM 2 /* a slip phase of L rows bears a polynomial of order L - 2 at most */

static const int ORDERS_LESS[] = {0, 1, 2};  /* at TL_FROM_REST and TL_TO_REST */
static const double EDGE_LENGTH = 2.0 / 3.0; /* of the window */
static const double EDGE_S = 0.018; /* of motion beside a stop, by whose line its torque there is told */

static int direction(double velocity, double standstill) {
  if (fabs(velocity) < standstill) return 0;
  return velocity > 0.0 ? 1 : velocity < 0.0 ? -1 : 0;
}

/* instant at which the joint comes to rest after its last moving row a: the vertex of the
 * parabola through the rows before it, or that row's own time when they do not slow down */
static double rest_time(const double *t_s, const double *angle, size_t n, size_t a) {
  double work[3 * PARABOLA], fit[3], from, to, at;

  if (!angle || a < PARABOLA + 1) return t_s[a];
  from = t_s[a - 1];
  to = t_s[a + 1 < n ? a + 1 : a];
  if (tl_window_fit(t_s + a - PARABOLA, angle + a - PARABOLA, PARABOLA, from, 2, work, fit) != TL_OK)
    return t_s[a];
  if (!(fit[1] * fit[2] < 0.0)) return t_s[a];
  at = from - fit[1] / fit[2];
  return at > to ? to : at;
}

/* a stop between the moving rows a and b (TL_NO_ROW: outside the block) */
static tl_stop make_stop(const double *t_s, const double *angle, size_t n, size_t a, size_t b) {
  tl_stop s = {a, b, t_s[0]};

  if (a == TL_NO_ROW) return s;
  s.begin_s = rest_time(t_s, angle, n, a);
  if (s.begin_s < t_s[a]) s.before = a - 1;
  return s;
}

/* append a stop, or let the last one grow over a slip phase too short to be motion */
static size_t append(tl_stop *stop, size_t stops, tl_stop next) {
  size_t phase_begin = stops ? stop[stops - 1].after : 0;
  int too_short = next.before == TL_NO_ROW || next.before + 1 < phase_begin + PHASE_ROWS;

  if (stops && too_short)
    stop[stops - 1].after = next.after;
  else if (too_short)
    stop[stops++] = (tl_stop){TL_NO_ROW, next.after, next.begin_s};
  else
    stop[stops++] = next;
  return stops;
}

size_t tl_find_stops(const double *t_s, const double *angle, const double *velocity, size_t n,
                     double standstill, tl_stop *stop) {
  size_t last = TL_NO_ROW, i, stops = 0;

  for (i = 0; i < n; i++) {
    int now = direction(velocity[i], standstill);
    int cut;

    if (now == 0) continue;
    cut = last == TL_NO_ROW ? i > QUIET_ROWS
                            : now != direction(velocity[last], standstill) || i - last > QUIET_ROWS;
    if (cut) stops = append(stop, stops, make_stop(t_s, angle, n, last, i));
    last = i;
  }
  /* at rest to the end of the block, or a last slip phase too short to be motion */
  if (last == TL_NO_ROW || n - last > QUIET_ROWS + 1)
    stops = append(stop, stops, make_stop(t_s, angle, n, last, TL_NO_ROW));
  else if (stops && stop[stops - 1].after != TL_NO_ROW && n - stop[stops - 1].after < PHASE_ROWS)
    stop[stops - 1].after = TL_NO_ROW;
  return stops;
}

static double sign_of(double x) {
  return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0;
}

/* share of the way from one side of a stop to the other: a short stop passes from sign to
 * sign in one ramp; in a hold each side's friction fades within half the bridge's time */
static double stop_slip(const tl_stop *s, const double *t_s, double before, double after, double at) {
  double end_s = s->after == TL_NO_ROW ? 0.0 : t_s[s->after], fade = 0.5 * TL_BRIDGE_S, left, right;

  if (s->before != TL_NO_ROW && s->after != TL_NO_ROW && end_s - s->begin_s < TL_BRIDGE_S) {
    double w = end_s > s->begin_s ? (at - s->begin_s) / (end_s - s->begin_s) : 1.0;
    return before + (after - before) * (w < 0.0 ? 0.0 : w > 1.0 ? 1.0 : w);
  }
  left = s->before == TL_NO_ROW ? 0.0 : 1.0 - (at - s->begin_s) / fade;
  right = s->after == TL_NO_ROW ? 0.0 : 1.0 - (end_s - at) / fade;
  return before * (left < 0.0 ? 0.0 : left > 1.0 ? 1.0 : left) + after * (right < 0.0 ? 0.0 : right);
}

/* sign of the motion on rows [begin, end): that of the way gone in its middle half, never of an extrapolated
 * edge nor of one noisy row */
static double phase_sign(const double *velocity, size_t begin, size_t end) {
  size_t edge = (end - begin) / 4, i;
  double way = 0.0;

  for (i = begin + edge; i + edge < end; i++) way += velocity[i];
  return sign_of(way);
}

void tl_slip_through_stops(const double *t_s, const double *velocity, size_t n, const tl_stop *stop,
                           size_t stops, double *slip) {
  size_t k, i = 0;

  for (k = 0; k <= stops; k++) {
    size_t end = k == stops ? n : stop[k].before == TL_NO_ROW ? 0 : stop[k].before + 1;
    double before = phase_sign(velocity, i, end), after;
    size_t next;

    for (; i < end; i++) slip[i] = before;
    if (k == stops || stop[k].after == TL_NO_ROW) {
      for (; k < stops && i < n; i++) slip[i] = stop_slip(&stop[k], t_s, before, 0.0, t_s[i]);
      break;
    }
    next = k + 1 == stops ? n : stop[k + 1].before + 1;
    after = phase_sign(velocity, stop[k].after, next);
    for (; i < stop[k].after; i++) slip[i] = stop_slip(&stop[k], t_s, before, after, t_s[i]);
  }
}

/* value and derivatives at row `at`, the first or the last, by a window that is shorter and of a lower order */
static tl_status slip_phase_edge(const tl_window *w, const double *t_s, const double *x, size_t n, size_t at,
                                 int orders_less, double *work, size_t work_n, double value[3]) {
  double reach_s = EDGE_LENGTH * w->length_s;
  int order = w->order - orders_less;
  size_t fewest = (size_t)w->order + 1, first, rows = 1;

  while (rows < n && (rows < fewest || fabs(t_s[at ? at - rows : rows] - t_s[at]) <= reach_s)) rows++;
  first = at ? n - rows : 0;
  if (tl_reconstruct_workspace(rows) > work_n) return TL_ERR_WORKSPACE;
  return tl_window_fit(t_s + first, x + first, rows, t_s[at], order < 2 ? 2 : order, work, value);
}

tl_status tl_reconstruct_slip_phase(const tl_window *window, const double *t_s, const double *x, size_t n,
                                    int edges, double *q, double *v, double *a, double *work, size_t work_n) {
  tl_window w = *window;
  double value[3];
  tl_status status;
  int side;

  if (w.order + PHASE_ORDER_ROOM > (int)n) w.order = (int)n - PHASE_ORDER_ROOM;
  if (w.order < 2) return TL_ERR_TOO_SHORT;
  status = tl_reconstruct(&w, t_s, x, n, q, v, a, work, work_n);
  for (side = TL_FROM_REST; status == TL_OK && side <= TL_TO_REST; side++) {
    size_t at = side == TL_TO_REST ? n - 1 : 0;
    if (!(edges & side)) continue;
    status = slip_phase_edge(&w, t_s, x, n, at, ORDERS_LESS[side], work, work_n, value);
    if (status != TL_OK) break;
    if (q) q[at] = value[0];
    v[at] = value[1];
    a[at] = value[2];
  }
  return status;
}

int tl_slip_phase_edges(const tl_stop *before, const tl_stop *after, const double *t_s) {
  return (before && tl_is_short_stop(before, t_s) ? TL_FROM_REST : 0) |
         (after && tl_is_short_stop(after, t_s) ? TL_TO_REST : 0);
}

int tl_is_short_stop(const tl_stop *s, const double *t_s) {
  return s->before != TL_NO_ROW && s->after != TL_NO_ROW && t_s[s->after] - t_s[s->before] <= TL_BRIDGE_S;
}

/* The value at row `at`, one end of rows [begin, end), of the straight line through them: a window's own estimate at the
 * end of a slip phase hangs on few samples there, and overshoots where the joint is braked hard. */
static double edge_value(const double *t_s, const double *column, size_t begin, size_t end, size_t at) {
  double n = (double)(end - begin), t = 0.0, x = 0.0, across = 0.0, square = 0.0;
  size_t i;

  for (i = begin; i < end; i++) t += t_s[i] - t_s[at];
  for (i = begin; i < end; i++) x += column[i];
  t /= n;
  for (i = begin; i < end; i++) {
    double away = t_s[i] - t_s[at] - t;
    across += away * column[i];
    square += away * away;
  }
  return x / n - (square > 0.0 ? t * across / square : 0.0);
}

/* Through a short stop the torque stays continuous while inertia and friction jump against
 * each other; so the whole row passes from the last moving sample to the next, slowly at first:
 * coming to rest the torque is flat, leaving rest it is not. `begin` and `end` are those of the slip phases beside it. */
static void bridge_stop(const tl_stop *s, const double *t_s, size_t begin, size_t end, double *column) {
  size_t first = s->before, last = s->after, i;
  double left, right, w;

  while (first > begin && t_s[s->before] - t_s[first - 1] < EDGE_S) first--;
  while (last + 1 < end && t_s[last + 1] - t_s[s->after] < EDGE_S) last++;
  left = edge_value(t_s, column, first, s->before + 1, s->before);
  right = edge_value(t_s, column, s->after, last + 1, s->after);
  for (i = s->before + 1; i < s->after; i++) {
    w = (t_s[i] - s->begin_s) / (t_s[s->after] - s->begin_s);
    w = w > 0.0 ? w * w : 0.0;
    column[i] = (1.0 - w) * left + w * right;
  }
}

void tl_bridge_stops(const tl_stop *stop, size_t stops, const double *t_s, size_t n, double *column) {
  size_t k;

  for (k = 0; k < stops; k++) {
    const tl_stop *s = &stop[k];
    if (tl_is_short_stop(s, t_s))
      bridge_stop(s, t_s, k ? stop[k - 1].after : 0, k + 1 < stops ? stop[k + 1].before + 1 : n, column);
  }
}
