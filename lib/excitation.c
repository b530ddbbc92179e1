/* excitation.c: see talus/experimental/excitation.h. */
#include "talus/experimental/excitation.h"

#include <math.h>
#include <string.h>

#include "excitation_internal.h"
#include "talus/math.h"
#include "talus/random.h"

#define PHASE_STREAM 0x65786369ULL /* of tl_random_uniform2: the multisine's phases */

/* ---- value at an instant --------------------------------------------------- */

/* a number that varies in time, with its first two derivatives */
typedef struct jet {
  double x, v, a;
} jet;

/* 10 u^3 - 15 u^4 + 6 u^5 over u = t / fade_s: velocity and acceleration are 0 at both ends */
static jet fade_at(const tl_excitation *e, double t) {
  jet w = {1.0, 0.0, 0.0};
  double u;

  if (t >= e->fade_s) return w;
  u = t / e->fade_s;
  w.x = u * u * u * (10.0 - u * (15.0 - 6.0 * u));
  w.v = 30.0 * u * u * (1.0 - u) * (1.0 - u) / e->fade_s;
  w.a = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (e->fade_s * e->fade_s);
  return w;
}

/* the series (14) and its derivatives; sin and cos of the multiples by rotation */
static void series_at(const tl_excitation *e, double t, jet x[TL_MAX_JOINTS]) {
  double cycles = e->base_hz * t, w = 2.0 * TL_PI * e->base_hz;
  double s1, c1, s = 0.0, c = 1.0;
  int i, j;

  tl_sincos(2.0 * TL_PI * (cycles - floor(cycles)), &s1, &c1);
  for (i = 0; i < e->harmonics; i++) {
    double next = s * c1 + c * s1, wi = w * (double)(i + 1);
    c = c * c1 - s * s1;
    s = next;
    for (j = 0; j < e->joints; j++) {
      double value = e->sine[j][i] * s + e->cosine[j][i] * c;
      x[j].x += value;
      x[j].v += wi * (e->sine[j][i] * c - e->cosine[j][i] * s);
      x[j].a -= wi * wi * value;
    }
  }
}

/* the share of a move that is done after `t` of it: trapezoidal speed */
static jet share_at(const tl_move *move, double t) {
  jet s = {1.0, 0.0, 0.0};
  double rate = 1.0 / (move->duration_s - move->ramp_s), left = move->duration_s - t;

  if (left <= 0.0) return s;
  if (t < move->ramp_s) {
    s.a = rate / move->ramp_s;
    s.v = s.a * t;
    s.x = 0.5 * s.a * t * t;
  } else if (left < move->ramp_s) {
    s.a = -rate / move->ramp_s;
    s.v = -s.a * left;
    s.x = 1.0 + 0.5 * s.a * left * left;
  } else {
    s.v = rate;
    s.x = rate * (t - 0.5 * move->ramp_s);
  }
  return s;
}

/* the last move that has begun at t (binary search) */
static const tl_move *move_at(const tl_excitation *e, double t) {
  int low = 0, high = e->moves - 1;

  while (low < high) {
    int middle = (low + high + 1) / 2;
    if (e->move[middle].begin_s <= t)
      low = middle;
    else
      high = middle - 1;
  }
  return &e->move[low];
}

static void moves_at(const tl_excitation *e, double t, jet x[TL_MAX_JOINTS]) {
  const tl_move *move;
  jet s;
  int j;

  if (e->moves == 0) return;
  move = move_at(e, t);
  s = share_at(move, t - move->begin_s);
  for (j = 0; j < e->joints; j++) {
    double travel = move->to[j] - move->from[j];
    x[j].x = move->from[j] + travel * s.x;
    x[j].v = travel * s.v;
    x[j].a = travel * s.a;
  }
}

void tl_excitation_at(const tl_excitation *e, double t_s, tl_motion *motion) {
  jet x[TL_MAX_JOINTS], w;
  double t = t_s > 0.0 ? t_s : 0.0;
  int j;

  memset(x, 0, sizeof x);
  memset(motion, 0, sizeof *motion);
  if (e->kind == TL_EXCITATION_RAMPS)
    moves_at(e, t, x);
  else
    series_at(e, t, x);
  w = fade_at(e, t);
  for (j = 0; j < e->joints; j++) {
    motion->q[j] = e->offset[j] + w.x * x[j].x;
    if (t_s < 0.0) continue;
    motion->v[j] = w.x * x[j].v + w.v * x[j].x;
    motion->a[j] = w.x * x[j].a + 2.0 * w.v * x[j].v + w.a * x[j].x;
  }
}

double tl_excitation_length_s(const tl_excitation *e) {
  const tl_move *last = &e->move[e->moves > 0 ? e->moves - 1 : 0];

  if (e->kind == TL_EXCITATION_FOURIER) return 1.0 / e->base_hz;
  return e->moves > 0 ? last->begin_s + last->duration_s : 0.0;
}

void tl_excitation_speed_up(tl_excitation *e, double factor) {
  int i;

  e->base_hz *= factor;
  e->fade_s /= factor;
  for (i = 0; i < e->moves; i++) {
    e->move[i].begin_s /= factor;
    e->move[i].duration_s /= factor;
    e->move[i].ramp_s /= factor;
  }
}

void tl_excitation_scale(tl_excitation *e, int joint, double factor) {
  int i;

  for (i = 0; i < e->harmonics; i++) {
    e->sine[joint][i] *= factor;
    e->cosine[joint][i] *= factor;
  }
  for (i = 0; i < e->moves; i++) {
    e->move[i].from[joint] *= factor;
    e->move[i].to[joint] *= factor;
  }
}

/* ---- the kinds --------------------------------------------------------------- */

static tl_status begin(tl_excitation *e, tl_excitation_kind kind, int joints) {
  if (!e || joints < 1 || joints > TL_MAX_JOINTS) return TL_ERR_ARGUMENT;
  memset(e, 0, sizeof *e);
  e->kind = kind;
  e->joints = joints;
  e->base_hz = 1.0;
  return TL_OK;
}

tl_status tl_excitation_paper(tl_excitation *e, int joints) {
  tl_status status = begin(e, TL_EXCITATION_FOURIER, joints);
  int i, j;

  if (status != TL_OK) return status;
  e->base_hz = 2.5;
  e->harmonics = 5;
  for (j = 0; j < joints; j++) {
    for (i = 0; i < e->harmonics; i++) {
      e->sine[j][i] = j == 0 ? 0.2 : 0.1;
      e->cosine[j][i] = j == 0 ? 0.1 : 0.05;
    }
  }
  return TL_OK;
}

tl_multisine_settings tl_multisine_defaults(const tl_model *m) {
  const tl_plant_bench *bench = &tl_plant_facts(m->plant)->bench;
  tl_multisine_settings s = {0.25, 8, 0.5, {0.0, 0.0}, {0.0, 0.0}, 2.0, 1};

  memcpy(s.amplitude, bench->multisine_amplitude, sizeof s.amplitude);
  return s;
}

static int multisine_in_range(const tl_multisine_settings *s, int joints) {
  int j;

  for (j = 0; j < joints; j++)
    if (!(s->amplitude[j] >= 0.0 && s->amplitude[j] < HUGE_VAL && fabs(s->centre[j]) < HUGE_VAL)) return 0;
  return s->base_hz > 0.0 && s->base_hz < HUGE_VAL && s->harmonics >= 1 && s->harmonics <= TL_MAX_HARMONICS &&
         fabs(s->exponent) <= 10.0 && s->fade_s >= 0.0 && s->fade_s < HUGE_VAL;
}

/* amplitudes of the wanted shape with phases drawn for (seed, joint, harmonic) */
static void draw_phases(tl_excitation *e, const tl_multisine_settings *s, int joint) {
  int i;

  for (i = 0; i < s->harmonics; i++) {
    double amplitude = 1.0 / tl_pow((double)(i + 1), s->exponent), draw[2], sin_phase, cos_phase;
    tl_random_uniform2(s->seed, PHASE_STREAM + (unsigned)joint, (uint64_t)i, draw);
    tl_sincos(2.0 * TL_PI * draw[0], &sin_phase, &cos_phase);
    e->sine[joint][i] = amplitude * sin_phase;
    e->cosine[joint][i] = amplitude * cos_phase;
  }
}

tl_status tl_excitation_multisine(tl_excitation *e, int joints, const tl_multisine_settings *s) {
  tl_peak peak[TL_MAX_PEAKS];
  tl_status status;
  int j;

  if (!s || joints < 1 || joints > TL_MAX_JOINTS) return TL_ERR_ARGUMENT;
  if (!multisine_in_range(s, joints)) return TL_ERR_RANGE;
  status = begin(e, TL_EXCITATION_FOURIER, joints);
  if (status != TL_OK) return status;
  e->base_hz = s->base_hz;
  e->harmonics = s->harmonics;
  for (j = 0; j < joints; j++) draw_phases(e, s, j);
  tl_excitation_find_peaks(NULL, e, peak);
  for (j = 0; j < joints; j++) { /* the range centred and stretched to what was asked for */
    const tl_peak *of = peak + j * TL_QUANTITIES;
    double low = of[TL_QUANTITY_POSITION_LOW].peak, high = of[TL_QUANTITY_POSITION_HIGH].peak;
    double factor = 2.0 * s->amplitude[j] / (high - low);
    tl_excitation_scale(e, j, factor);
    e->offset[j] = s->centre[j] - 0.5 * factor * (low + high);
  }
  e->fade_s = s->fade_s;
  return TL_OK;
}

tl_ramp_settings tl_ramp_defaults(const tl_model *m) {
  const tl_plant_bench *bench = &tl_plant_facts(m->plant)->bench;
  tl_ramp_settings s = {{0.0}, {0.0, 0.0}, 1.2, 0.4, bench->ramp_acceleration};

  memcpy(s.speed, bench->ramp_speed, sizeof s.speed);
  memcpy(s.amplitude, bench->ramp_amplitude, sizeof s.amplitude);
  return s;
}

static int ramps_in_range(const tl_ramp_settings *s, int joints) {
  int i;

  for (i = 0; i < TL_RAMP_SPEEDS; i++)
    if (!(s->speed[i] > 0.0 && s->speed[i] < HUGE_VAL)) return 0;
  for (i = 0; i < joints; i++)
    if (!(s->amplitude[i] >= 0.0 && s->amplitude[i] < HUGE_VAL)) return 0;
  return s->travel_s > 0.0 && s->hold_s >= 0.0 && s->hold_s < HUGE_VAL && s->acceleration > 0.0 &&
         s->acceleration < HUGE_VAL;
}

/* where the last move ends, in time and place, and a new one behind it */
static tl_move *next_move(tl_excitation *e) {
  tl_move *move = &e->move[e->moves];

  memset(move, 0, sizeof *move);
  if (e->moves > 0) {
    move->begin_s = move[-1].begin_s + move[-1].duration_s;
    memcpy(move->from, move[-1].to, sizeof move->from);
    memcpy(move->to, move[-1].to, sizeof move->to);
  }
  e->moves++;
  return move;
}

/* a ramp to `to` at `speed` of the joint that travels farthest, and the hold behind it */
static void add_ramp(tl_excitation *e, const tl_ramp_settings *s, double speed,
                     const double to[TL_MAX_JOINTS]) {
  tl_move *move = next_move(e);
  double travel = 0.0;
  int j;

  for (j = 0; j < TL_MAX_JOINTS; j++) {
    move->to[j] = to[j];
    if (fabs(to[j] - move->from[j]) > travel) travel = fabs(to[j] - move->from[j]);
  }
  if (travel > 0.0) { /* a short way never reaches the speed */
    double reached = sqrt(travel * s->acceleration) < speed ? sqrt(travel * s->acceleration) : speed;
    move->ramp_s = reached / s->acceleration;
    move->duration_s = travel / reached + move->ramp_s;
  }
  if (!(move->duration_s > 0.0)) e->moves--;
  if (s->hold_s > 0.0) next_move(e)->duration_s = s->hold_s;
}

/* to one side, to the other and back, the joints whose bit is set in `which`; where both move
 * they go to opposite sides, so that the foot's angle is not twice the shank's */
static void add_cycle(tl_excitation *e, const tl_ramp_settings *s, double speed, int which) {
  double to[TL_MAX_JOINTS] = {0.0, 0.0};
  int side, j;

  for (side = 1; side >= -1; side -= 2) {
    for (j = 0; j < e->joints; j++) {
      double reach = speed * s->travel_s < s->amplitude[j] ? speed * s->travel_s : s->amplitude[j];
      to[j] = which >> j & 1 ? (double)side * reach : 0.0;
      if (which == 3 && j == 1) to[j] = -to[j];
    }
    add_ramp(e, s, speed, to);
  }
  to[0] = to[1] = 0.0;
  add_ramp(e, s, speed, to);
}

tl_status tl_excitation_ramps(tl_excitation *e, int joints, const tl_ramp_settings *s) {
  tl_status status;
  int which, k;

  if (!s || joints < 1 || joints > TL_MAX_JOINTS) return TL_ERR_ARGUMENT;
  if (!ramps_in_range(s, joints)) return TL_ERR_RANGE;
  status = begin(e, TL_EXCITATION_RAMPS, joints);
  if (status != TL_OK) return status;
  for (which = 1; which < 1 << joints; which++)
    for (k = 0; k < TL_RAMP_SPEEDS; k++) add_cycle(e, s, s->speed[k], which);
  return TL_OK;
}
