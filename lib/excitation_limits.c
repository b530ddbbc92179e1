/* excitation_limits.c: what a trajectory asks of the joints, and how it is made to fit. See
 * talus/experimental/excitation.h. */
#include <math.h>
#include <string.h>

#include "excitation_internal.h"
#include "talus/experimental/excitation.h"

/* ---- peaks ----------------------------------------------------------------- */

#define SERIES_POINTS 64 /* of the grid, in a period of the highest harmonic */
#define PHASE_POINTS 32  /* in each of a move's three phases */
#define GOLDEN 0.6180339887498949
#define GOLDEN_STEPS 40

/* the grid of instants on which peaks are looked for: uniform over fade and one period, or
 * uniform in each phase of each move */
static size_t grid_count(const tl_excitation *e) {
  double points;

  if (e->kind == TL_EXCITATION_RAMPS) return (size_t)e->moves * 3 * PHASE_POINTS + 1;
  points = (1.0 + e->fade_s * e->base_hz) * (double)(e->harmonics > 0 ? e->harmonics : 1) * SERIES_POINTS;
  return (size_t)floor(points + 0.5) + 1;
}

static double grid_time(const tl_excitation *e, size_t k) {
  size_t phase = k / PHASE_POINTS % 3;
  double share = (double)(k % PHASE_POINTS) / PHASE_POINTS;
  const tl_move *move;

  if (e->kind == TL_EXCITATION_FOURIER)
    return (double)k / (e->base_hz * (double)(e->harmonics > 0 ? e->harmonics : 1) * SERIES_POINTS);
  if (k + 1 == grid_count(e)) return tl_excitation_length_s(e);
  move = &e->move[k / (3 * PHASE_POINTS)];
  if (phase == 0) return move->begin_s + share * move->ramp_s;
  if (phase == 1) return move->begin_s + move->ramp_s + share * (move->duration_s - 2.0 * move->ramp_s);
  return move->begin_s + move->duration_s - (1.0 - share) * move->ramp_s;
}

/* every quantity at an instant, as something whose largest value is looked for; value[] keeps signs */
static void quantities_at(const tl_model *m, const tl_excitation *e, double t, double size[TL_MAX_PEAKS],
                          double value[TL_MAX_PEAKS]) {
  double torque[TL_MAX_JOINTS] = {0.0, 0.0};
  tl_motion now;
  int j, k;

  tl_excitation_at(e, t, &now);
  if (m) {
    tl_slip_from_velocity(m, &now);
    tl_inverse(m, &now, torque);
  }
  for (j = 0; j < e->joints; j++) {
    double *of = value + j * TL_QUANTITIES, *in = size + j * TL_QUANTITIES;
    of[TL_QUANTITY_POSITION_LOW] = of[TL_QUANTITY_POSITION_HIGH] = now.q[j];
    of[TL_QUANTITY_SPEED] = now.v[j];
    of[TL_QUANTITY_ACCELERATION] = now.a[j];
    of[TL_QUANTITY_TORQUE] = torque[j];
    for (k = 0; k < TL_QUANTITIES; k++) in[k] = fabs(of[k]);
    in[TL_QUANTITY_POSITION_LOW] = -now.q[j];
    in[TL_QUANTITY_POSITION_HIGH] = now.q[j];
  }
}

/* a look at quantity `which` at one more instant; `peak` keeps it when it beats *best */
static double probe(const tl_model *m, const tl_excitation *e, int which, double t, tl_peak *peak,
                    double *best) {
  double size[TL_MAX_PEAKS] = {0.0}, value[TL_MAX_PEAKS] = {0.0};

  quantities_at(m, e, t, size, value);
  if (size[which] > *best) {
    *best = size[which];
    peak->peak = value[which];
    peak->t_s = t;
  }
  return size[which];
}

/* golden section for quantity `which` between low and high; never less than what `peak` holds */
static void refine(const tl_model *m, const tl_excitation *e, int which, double low, double high,
                   tl_peak *peak, double best) {
  double left = high - GOLDEN * (high - low), right = low + GOLDEN * (high - low);
  double at_left = probe(m, e, which, left, peak, &best), at_right = probe(m, e, which, right, peak, &best);
  int step;

  for (step = 0; step < GOLDEN_STEPS; step++) {
    if (at_left > at_right) {
      high = right;
      right = left;
      at_right = at_left;
      left = high - GOLDEN * (high - low);
      at_left = probe(m, e, which, left, peak, &best);
    } else {
      low = left;
      left = right;
      at_left = at_right;
      right = low + GOLDEN * (high - low);
      at_right = probe(m, e, which, right, peak, &best);
    }
  }
}

void tl_excitation_find_peaks(const tl_model *m, const tl_excitation *e, tl_peak peak[TL_MAX_PEAKS]) {
  double size[TL_MAX_PEAKS] = {0.0}, value[TL_MAX_PEAKS] = {0.0}, best[TL_MAX_PEAKS] = {0.0};
  size_t at[TL_MAX_PEAKS] = {0}, k, n = grid_count(e);
  int i, count = e->joints * TL_QUANTITIES;

  for (k = 0; k < n; k++) {
    double t = grid_time(e, k);
    quantities_at(m, e, t, size, value);
    for (i = 0; i < count; i++) {
      if (k > 0 && size[i] <= best[i]) continue;
      best[i] = size[i];
      at[i] = k;
      peak[i].joint = i / TL_QUANTITIES;
      peak[i].quantity = (tl_quantity)(i % TL_QUANTITIES);
      peak[i].peak = value[i];
      peak[i].t_s = t;
    }
  }
  for (i = 0; i < count; i++)
    refine(m, e, i, grid_time(e, at[i] > 0 ? at[i] - 1 : 0), grid_time(e, at[i] + 1 < n ? at[i] + 1 : n - 1),
           &peak[i], best[i]);
}

/* ---- limits ---------------------------------------------------------------- */

tl_limits tl_limits_none(void) {
  tl_limits none = {-HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL};
  return none;
}

const char *tl_quantity_name(tl_quantity quantity) {
  static const char *const name[TL_QUANTITIES] = {"position", "position", "speed", "acceleration", "torque"};

  return (int)quantity >= 0 && (int)quantity < TL_QUANTITIES ? name[quantity] : NULL;
}

static void apply_limit(const tl_limits *limits, tl_peak *peak) {
  double sign = peak->peak < 0.0 ? -1.0 : 1.0;

  switch (peak->quantity) {
  case TL_QUANTITY_POSITION_LOW: peak->limit = limits->position_low; break;
  case TL_QUANTITY_POSITION_HIGH: peak->limit = limits->position_high; break;
  case TL_QUANTITY_SPEED: peak->limit = sign * limits->speed; break;
  case TL_QUANTITY_ACCELERATION: peak->limit = sign * limits->acceleration; break;
  case TL_QUANTITY_TORQUE: peak->limit = sign * limits->torque; break;
  }
  if (peak->quantity == TL_QUANTITY_POSITION_LOW) sign = -1.0;
  if (peak->quantity == TL_QUANTITY_POSITION_HIGH) sign = 1.0;
  peak->excess = sign * (peak->peak - peak->limit);
}

void tl_excitation_peaks(const tl_model *m, const tl_limits limits[TL_MAX_JOINTS], const tl_excitation *e,
                         tl_peak peak[TL_MAX_PEAKS]) {
  int i;

  tl_excitation_find_peaks(m, e, peak);
  for (i = 0; i < e->joints * TL_QUANTITIES; i++) apply_limit(&limits[peak[i].joint], &peak[i]);
}

static int joints_match(const tl_model *m, const tl_excitation *e) {
  return e->joints >= 1 && e->joints == tl_joint_count(m);
}

tl_status tl_excitation_check(const tl_model *m, const tl_limits limits[TL_MAX_JOINTS],
                              const tl_excitation *e, tl_peak peak[TL_MAX_PEAKS], int *broken) {
  tl_peak all[TL_MAX_PEAKS];
  int i;

  if (!joints_match(m, e)) return TL_ERR_ARGUMENT;
  tl_excitation_peaks(m, limits, e, all);
  *broken = 0;
  for (i = 0; i < e->joints * TL_QUANTITIES; i++)
    if (!(all[i].excess <= 0.0)) peak[(*broken)++] = all[i];
  return TL_OK;
}

/* ---- scaling to fit ---------------------------------------------------------- */

#define INSIDE (1.0 - 1e-6)
#define SLOWEST 1e-3
#define BISECTIONS 30

/* what a joint's amplitude may be multiplied with; above 1 there is room left */
static double amplitude_factor(const tl_limits *limits, double offset, const tl_peak *of_joint) {
  double down = offset - of_joint[TL_QUANTITY_POSITION_LOW].peak;
  double up = of_joint[TL_QUANTITY_POSITION_HIGH].peak - offset;
  double factor = HUGE_VAL;

  if (up > 0.0) factor = (limits->position_high - offset) / up;
  if (down > 0.0 && (offset - limits->position_low) / down < factor)
    factor = (offset - limits->position_low) / down;
  return factor;
}

static tl_status fit_amplitudes(const tl_model *m, const tl_limits *limits, tl_excitation *e, tl_scaling *s) {
  tl_peak peak[TL_MAX_PEAKS];
  int j;

  tl_excitation_peaks(m, limits, e, peak);
  for (j = 0; j < e->joints; j++) {
    if (!(e->offset[j] >= limits[j].position_low && e->offset[j] <= limits[j].position_high))
      return TL_ERR_RANGE;
    s->amplitude[j] = amplitude_factor(&limits[j], e->offset[j], peak + j * TL_QUANTITIES);
    s->amplitude[j] = s->amplitude[j] < 1.0 ? s->amplitude[j] * INSIDE : 1.0;
    tl_excitation_scale(e, j, s->amplitude[j]);
  }
  return TL_OK;
}

/* the factor at which speed (proportional to it) and acceleration (to its square) hold */
static double speed_factor(const tl_limits *limits, int joints, const tl_peak *peak) {
  double factor = 1.0;
  int j;

  for (j = 0; j < joints; j++) {
    const tl_peak *of = peak + j * TL_QUANTITIES;
    double v = fabs(of[TL_QUANTITY_SPEED].peak), a = fabs(of[TL_QUANTITY_ACCELERATION].peak);
    if (v > limits[j].speed && limits[j].speed / v < factor) factor = limits[j].speed / v;
    if (a > limits[j].acceleration && sqrt(limits[j].acceleration / a) < factor)
      factor = sqrt(limits[j].acceleration / a);
  }
  return factor < 1.0 ? factor * INSIDE : 1.0;
}

static int torque_holds(const tl_model *m, const tl_limits *limits, const tl_excitation *e, double speed) {
  tl_excitation slower = *e;
  tl_peak peak[TL_MAX_PEAKS];
  int j;

  tl_excitation_speed_up(&slower, speed);
  tl_excitation_find_peaks(m, &slower, peak);
  for (j = 0; j < e->joints; j++)
    if (!(fabs(peak[j * TL_QUANTITIES + TL_QUANTITY_TORQUE].peak) <= limits[j].torque * INSIDE)) return 0;
  return 1;
}

/* the largest factor at most `speed` with the torque inside its limit, by bisection: `low`
 * always holds, `high` never does */
static tl_status fit_torque(const tl_model *m, const tl_limits *limits, const tl_excitation *e,
                            double *speed) {
  double low = SLOWEST * *speed, high = *speed;
  int i;

  if (torque_holds(m, limits, e, high)) return TL_OK;
  if (!torque_holds(m, limits, e, low)) return TL_ERR_NO_CONVERGENCE;
  for (i = 0; i < BISECTIONS; i++) {
    double middle = 0.5 * (low + high);
    if (torque_holds(m, limits, e, middle))
      low = middle;
    else
      high = middle;
  }
  *speed = low;
  return TL_OK;
}

tl_status tl_excitation_fit(const tl_model *m, const tl_limits limits[TL_MAX_JOINTS], tl_excitation *e,
                            tl_scaling *scaling) {
  tl_scaling s = {{1.0, 1.0}, 1.0};
  tl_peak peak[TL_MAX_PEAKS];
  tl_excitation fitted;
  tl_status status;

  if (!joints_match(m, e)) return TL_ERR_ARGUMENT;
  fitted = *e;
  status = fit_amplitudes(m, limits, &fitted, &s);
  if (status != TL_OK) return status;
  tl_excitation_find_peaks(m, &fitted, peak);
  s.speed = speed_factor(limits, fitted.joints, peak);
  status = fit_torque(m, limits, &fitted, &s.speed);
  if (status != TL_OK) return status;
  tl_excitation_speed_up(&fitted, s.speed);
  *e = fitted;
  if (scaling) *scaling = s;
  return TL_OK;
}
