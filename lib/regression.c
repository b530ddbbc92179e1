/* regression.c: see talus/experimental/regression.h. */
#include "talus/experimental/regression.h"

#include <math.h>
#include <string.h>

#include "math_inline.h"

#define KNOWN(columns) (columns)        /* place of the known part in `raw` */
#define EFFORT(columns) ((columns) + 1) /* and of what was measured */
#define RAW_COLUMNS (TL_MAX_ROW + 2)
#define TEMPERATURE_S 2.0 /* that a drive's temperature is averaged over */

tl_status tl_regression_init(tl_regression *r, const tl_model *m, uint32_t recorded,
                             const tl_score_settings *score, double step_s) {
  tl_status status;

  if (!r || !m || !score) return TL_ERR_ARGUMENT;
  memset(r, 0, sizeof *r);
  r->model = *m;
  r->score = *score;
  r->step_s = step_s;
  r->recorded = recorded;
  r->temperature[0] = r->temperature[1] = TL_CHANNEL_COUNT;
  status = tl_layout_init(&r->layout, m, recorded);
  /* gravity needs the angle; where only a velocity was recorded its columns stay empty */
  if (status == TL_OK && r->layout.position[0] == TL_CHANNEL_COUNT) r->model.gravity_m_s2 = 0.0;
  return status == TL_OK ? tl_lowpass_init(&r->lowpass, score->order, score->lowpass_hz, step_s) : status;
}

static tl_channel temperature_of(const tl_model *m, int joint) {
  return joint < tl_joint_count(m) ? tl_plant_facts(m->plant)->sensors.temperature[joint] : TL_NO_CHANNEL;
}

/* temperatures that effects need; 0 if one was not recorded */
static int find_temperatures(const tl_regression *r, const tl_effect *effect, int effects,
                             tl_channel found[TL_MAX_JOINTS]) {
  int i;

  found[0] = found[1] = TL_CHANNEL_COUNT;
  for (i = 0; i < effects; i++) {
    if (!tl_effect_needs_temperature(&effect[i])) continue;
    tl_channel channel = temperature_of(&r->model, effect[i].joint);
    if (channel == TL_CHANNEL_COUNT || !(r->recorded & TL_CHANNEL_BIT(channel))) return 0;
    found[effect[i].joint] = channel;
  }
  return 1;
}

tl_status tl_regression_set_effects(tl_regression *r, const tl_effect *effect, int effects, double begin_s) {
  tl_transmission changed[TL_MAX_JOINTS];
  tl_effect_change change[TL_MAX_JOINTS];
  tl_channel temperature[TL_MAX_JOINTS];
  tl_status status;
  int j;

  if (!find_temperatures(r, effect, effects, temperature)) return TL_ERR_UNSUPPORTED;
  for (j = 0; j < TL_MAX_JOINTS; j++) {
    change[j] = tl_effects_change(effect, effects, j);
    status = tl_effect_change_linkage(&change[j], &r->model.drive[j].transmission, &changed[j]);
    if (status != TL_OK) return status;
  }
  for (j = 0; j < TL_MAX_JOINTS; j++) {
    r->model.drive[j].transmission = changed[j];
    r->delay_s[j] = change[j].delay_s;
    r->telemetry_delay_s[j] = change[j].telemetry_delay_s;
    r->torque_constant_error[j] = change[j].torque_constant_error;
    r->temperature[j] = temperature[j];
  }
  r->effect = effect;
  r->effects = effects;
  r->begin_s = begin_s;
  return TL_OK;
}

double tl_regression_margin_s(const tl_regression *r) {
  double filter_s = (double)(r->lowpass.settling + TL_LOWPASS_PAD) * r->step_s, window_s = 0.0;
  double memory_s = 0.0;
  int j;

  for (j = 0; j < r->effects; j++)
    if (r->effect[j].kind->memory_s > memory_s) memory_s = r->effect[j].kind->memory_s;

  for (j = 0; j < tl_joint_count(&r->model); j++)
    if (r->sensing[j].window.length_s > window_s) window_s = r->sensing[j].window.length_s;
  return filter_s + memory_s + r->score.guard_s + 2.0 * window_s + 2.0 * TL_BRIDGE_S +
         TL_GAP_STEPS * r->step_s;
}

/* of the kinematics, or of the effects over a block: columns, their sum, and their own work */
static size_t block_work(int joints, size_t capacity) {
  size_t effects = (TL_EFFECT_MAX_STRENGTHS + 1) * capacity + tl_effect_prepared_memory(joints, capacity);
  size_t kinematics = tl_kinematics_workspace(capacity);

  return effects > kinematics ? effects : kinematics;
}

size_t tl_regression_memory(const tl_regression *r, size_t capacity, size_t grid) {
  size_t joints = (size_t)tl_joint_count(&r->model);

  return tl_track_memory((int)joints, capacity) + joints * RAW_COLUMNS * (capacity + grid) + grid +
         block_work((int)joints, capacity);
}

void tl_regression_space_init(tl_regression_space *space, const tl_regression *r, size_t capacity,
                              size_t grid, double *memory, tl_stop *stops, uint8_t *mask) {
  int joints = tl_joint_count(&r->model), j;

  memset(space, 0, sizeof *space);
  space->capacity = capacity;
  space->grid = grid;
  tl_track_init(&space->track, joints, capacity, memory, stops);
  memory += tl_track_memory(joints, capacity);
  for (j = 0; j < joints; j++) {
    tl_rows *rows = &space->rows[j];

    space->raw[j] = memory;
    memory += RAW_COLUMNS * capacity;
    rows->columns = tl_row_index(&r->model, j, rows->index);
    rows->stride = grid;
    rows->x = memory;
    rows->kind = mask + (size_t)j * grid;
    memory += RAW_COLUMNS * grid;
  }
  space->work = memory;
  space->work_n = grid + block_work(joints, capacity);
}

/* column c of a joint's raw rows, and of its rows on the grid */
static double *raw_column(const tl_regression_space *space, int joint, int c) {
  return space->raw[joint] + (size_t)c * space->capacity;
}

static double *rows_column(const tl_rows *rows, int c) {
  return rows->x + (size_t)c * rows->stride;
}

/* ---- at the recording's rows -------------------------------------------- */

static void motion_at(const tl_model *m, const tl_track *track, int joints, size_t i, tl_motion *now) {
  double foot;
  int j;

  for (j = 0; j < joints; j++) {
    now->q[j] = track->q[j][i];
    now->v[j] = track->v[j][i];
    now->a[j] = track->a[j][i];
    now->slip[j] = track->slip[j][i];
  }
  if (m->form != TL_FORM_PAPER) return;
  /* the paper's print lets the ankle rub on the foot's absolute speed, whose stops are not sought */
  foot = now->v[0] + now->v[1];
  now->slip[1] = foot > 0.0 ? 1.0 : foot < 0.0 ? -1.0 : 0.0;
}

/* x at an instant near row i, between the rows about it; the ends hold */
static double value_at(const tl_block *block, const double *x, size_t i, double at_s) {
  const double *t = block->t_s;
  double share;

  while (i > 0 && t[i] > at_s) i--;
  while (i + 1 < block->n && t[i + 1] <= at_s) i++;
  if (i + 1 == block->n || at_s <= t[i]) return x[i];
  share = (at_s - t[i]) / (t[i + 1] - t[i]);
  return x[i] + share * (x[i + 1] - x[i]);
}

/* The drive's torque at a row's instant. Where it is an input, beside a sensor at the output, a current
 * that was sampled late stands further on, and a wrong torque constant is set right. */
static double effort_at(const tl_regression *r, const tl_block *block, int joint, size_t i) {
  const double *effort = block->channel[r->layout.effort[joint]];
  double delay = r->delay_s[joint], scale = r->layout.effort_scale[joint];

  if (r->layout.load == TL_CHANNEL_COUNT) return scale * effort[i];
  scale *= 1.0 + r->torque_constant_error[joint];
  return scale * (delay == 0.0 ? effort[i] : value_at(block, effort, i, block->t_s[i] + delay));
}

/* A gear's temperature changes more slowly than its sensor's noise: the mean of the rows of TEMPERATURE_S about row i,
 * those at the ends of the block held beyond it. */
static double temperature_at(const tl_regression *r, const tl_block *block, int joint, size_t i) {
  const double *temp =
      r->temperature[joint] == TL_CHANNEL_COUNT ? NULL : block->channel[r->temperature[joint]];
  ptrdiff_t rows = (ptrdiff_t)(TEMPERATURE_S / r->step_s), last = (ptrdiff_t)block->n - 1, k, at;
  double sum = 0.0;

  if (!temp) return 0.0;
  rows = rows < 1 ? 1 : rows;
  for (k = 0; k < rows; k++) {
    at = (ptrdiff_t)i - rows / 2 + k;
    sum += temp[at < 0 ? 0 : at > last ? last : at];
  }
  return sum / (double)rows;
}

/* what the modelled effects add at one instant */
static double effects_at(const tl_regression *r, const tl_block *block, const tl_motion *now, int joint,
                         size_t i) {
  double effort;
  int sensor = r->layout.load != TL_CHANNEL_COUNT;

  if (r->effects == 0) return 0.0;
  effort = effort_at(r, block, joint, i);
  return tl_effects_torque(r->effect, r->effects, &r->model, now, joint, block->t_s[i] - r->begin_s,
                           temperature_at(r, block, joint, i), sensor ? &effort : NULL);
}

static void regressor_rows(const tl_regression *r, const tl_block *block, tl_regression_space *space) {
  int joints = tl_joint_count(&r->model), j, k;
  double row[TL_MAX_JOINTS * TL_MAX_ROW], known[TL_MAX_JOINTS];
  tl_motion now;
  size_t i;

  memset(&now, 0, sizeof now);
  for (i = 0; i < block->n; i++) {
    motion_at(&r->model, &space->track, joints, i, &now);
    tl_regressor(&r->model, &now, row, known);
    for (j = 0; j < joints; j++) {
      int columns = space->rows[j].columns;
      for (k = 0; k < columns; k++) raw_column(space, j, k)[i] = row[tl_entry(TL_MAX_ROW, j, k)];
      raw_column(space, j, KNOWN(columns))[i] = known[j] + effects_at(r, block, &now, j, i);
    }
  }
}

/* the block's motion, as effects with a memory look at it */
static tl_effect_segment segment_of(const tl_regression *r, const tl_block *block, const tl_track *track) {
  tl_effect_segment s;
  int j;

  memset(&s, 0, sizeof s);
  s.model = &r->model;
  s.n = block->n;
  s.t_s = block->t_s;
  for (j = 0; j < tl_joint_count(&r->model); j++) {
    s.q[j] = track->q[j];
    s.v[j] = track->v[j];
    s.a[j] = track->a[j];
    s.slip[j] = track->slip[j];
    s.stop[j] = track->stop[j];
    s.stops[j] = track->stops[j];
    if (!r->sensing[j].across) s.window[j] = &r->sensing[j].window;
  }
  return s;
}

/* effects that are no law of the instant, into what is known of each joint */
static void effects_over(const tl_regression *r, const tl_block *block, tl_regression_space *space) {
  double *sum = space->work, *column = sum + block->n, *known;
  tl_effect_segment s = segment_of(r, block, &space->track);
  tl_effect_prepared prepared;
  size_t i;
  int j;

  if (r->effects == 0) return;
  tl_effect_prepare(&prepared, &s, column + TL_EFFECT_MAX_STRENGTHS * block->n);
  for (j = 0; j < tl_joint_count(&r->model); j++) {
    for (i = 0; i < block->n; i++) sum[i] = 0.0;
    tl_effects_segment_torque(r->effect, r->effects, &prepared, j, column, sum);
    known = raw_column(space, j, KNOWN(space->rows[j].columns));
    for (i = 0; i < block->n; i++) known[i] += sum[i];
  }
}

/* a joint's columns, and what is known, as they were `delay_s` ago */
static void delay_rows(const tl_block *block, int joint, double delay_s, tl_regression_space *space) {
  double *late = space->work;
  size_t i;
  int c;

  if (delay_s == 0.0) return;
  for (c = 0; c <= space->rows[joint].columns; c++) {
    double *column = raw_column(space, joint, c);
    for (i = 0; i < block->n; i++) late[i] = value_at(block, column, i, block->t_s[i] - delay_s);
    memcpy(column, late, block->n * sizeof *late);
  }
}

/* A recorded velocity runs on through a stop: nothing is cut there (tl_kinematics), so nothing is to be bridged. */
static void bridge_stops(const tl_regression *r, const tl_block *block, int joint,
                         tl_regression_space *space) {
  const tl_track *track = &space->track;
  int c;

  if (r->layout.position[joint] == TL_CHANNEL_COUNT) return;
  for (c = 0; c <= space->rows[joint].columns; c++)
    tl_bridge_stops(track->stop[joint], track->stops[joint], block->t_s, block->n,
                    raw_column(space, joint, c));
}

void tl_regression_columns(const tl_regression *r, const tl_effect_segment *s, int joint, double begin_s,
                           double *column, size_t columns, double *out, size_t grid) {
  size_t c;

  for (c = 0; c < columns && joint >= 0 && r->layout.position[joint] != TL_CHANNEL_COUNT; c++)
    tl_bridge_stops(s->stop[joint], s->stops[joint], s->t_s, s->n, column + c * s->n);
  tl_grid_resample_batch(s->t_s, column, s->n, columns, begin_s, r->step_s, out, grid);
  tl_lowpass_zero_phase_batch(&r->lowpass, out, grid, columns);
}

/* What was measured; with a sensor at the output that is the load, and the model's torque
 * counts against the drive's: load = effort - (row base + known). */
static void measured_rows(const tl_regression *r, const tl_block *block, int joint,
                          tl_regression_space *space) {
  int columns = space->rows[joint].columns, c;
  double *known = raw_column(space, joint, KNOWN(columns)),
         *measured = raw_column(space, joint, EFFORT(columns));
  const double *load = r->layout.load == TL_CHANNEL_COUNT ? NULL : block->channel[r->layout.load];
  size_t i;

  for (i = 0; i < block->n; i++) measured[i] = load ? load[i] : effort_at(r, block, joint, i);
  if (!load) return;
  for (c = 0; c < columns; c++)
    for (i = 0; i < block->n; i++) raw_column(space, joint, c)[i] *= -1.0;
  for (i = 0; i < block->n; i++) known[i] = effort_at(r, block, joint, i) - known[i];
}

tl_status tl_regression_motion(const tl_regression *r, const tl_block *block, tl_regression_space *space) {
  int j;
  tl_status status;

  if (!r || !block || !space) return TL_ERR_ARGUMENT;
  if (block->n > space->capacity) return TL_ERR_WORKSPACE;
  status = tl_kinematics(&r->model, &r->layout, r->sensing, block, space->work, space->work_n, &space->track);
  if (status != TL_OK) return status;
  regressor_rows(r, block, space);
  effects_over(r, block, space);
  for (j = 0; j < tl_joint_count(&r->model); j++) {
    bridge_stops(r, block, j, space);
    /* a current sampled late shows the torque of an earlier instant */
    if (r->layout.load == TL_CHANNEL_COUNT) delay_rows(block, j, r->delay_s[j], space);
    measured_rows(r, block, j, space);
    if (r->layout.load != TL_CHANNEL_COUNT) delay_rows(block, j, -r->telemetry_delay_s[j], space);
  }
  return TL_OK;
}

double tl_regression_predict(const tl_regression_space *space, int joint, const double *base, size_t i) {
  const tl_rows *rows = &space->rows[joint];
  double sum = raw_column(space, joint, KNOWN(rows->columns))[i];
  int c;

  for (c = 0; c < rows->columns; c++) sum += raw_column(space, joint, c)[i] * base[rows->index[c]];
  return sum;
}

/* ---- on the grid --------------------------------------------------------- */

/* grid instants [first, first + n) that the block covers, and of them the span's own [from, to) */
typedef struct grid_part {
  size_t first, n, from, to;
} grid_part;

/* the first k with begin + k step >= at */
static size_t grid_index(double begin_s, double step_s, double at) {
  double k = (at - begin_s) / step_s, whole;

  if (!(k > 0.0)) return 0;
  whole = floor(k);
  return (size_t)(whole < k ? whole + 1.0 : whole);
}

static grid_part part_of(const tl_regression *r, const tl_block *block, const tl_span *span) {
  size_t all = tl_grid_count(span->segment_begin_s, span->segment_end_s, r->step_s), last;
  grid_part g;

  g.first = grid_index(span->segment_begin_s, r->step_s, block->t_s[0]);
  last = grid_index(span->segment_begin_s, r->step_s, block->t_s[block->n - 1]);
  last = last < all ? last : all;
  g.n = last > g.first ? last - g.first : 0;
  g.from = grid_index(span->segment_begin_s, r->step_s, span->begin_s);
  g.to = span->end_s < span->segment_end_s ? grid_index(span->segment_begin_s, r->step_s, span->end_s) : all;
  g.from = g.from < g.first ? g.first : g.from;
  g.to = g.to < g.first + g.n ? g.to : g.first + g.n;
  return g;
}

/* which of the part's own rows count */
static void mark_rows(const tl_regression *r, const tl_span *span, const tl_block *block, int joint,
                      grid_part g, tl_regression_space *space) {
  size_t all = tl_grid_count(span->segment_begin_s, span->segment_end_s, r->step_s);
  size_t trim = (size_t)(r->score.trim_s / r->step_s), k;
  int too_short = (double)all * r->step_s < 3.0 * r->score.trim_s;
  tl_rows *rows = &space->rows[joint];

  tl_grid_resample(block->t_s, space->track.speed[joint], block->n,
                   span->segment_begin_s + (double)g.first * r->step_s, r->step_s, space->work, g.n);
  tl_score_keep(&r->score, space->work, g.n, r->step_s, rows->kind);
  for (k = 0; k < g.n; k++) {
    size_t at = g.first + k;
    rows->kind[k] = rows->kind[k] ? TL_ROW_SCORED : TL_ROW_STANDSTILL;
    if (too_short || at < trim || at + trim >= all) rows->kind[k] = TL_ROW_TRIMMED;
  }
  memmove(rows->kind, rows->kind + (g.from - g.first), g.to - g.from);
}

/* the target is measured - known; both through the grid and the filter, then the span's own part */
static void grid_rows(const tl_regression *r, const tl_span *span, const tl_block *block, int joint,
                      grid_part g, tl_regression_space *space) {
  tl_rows *rows = &space->rows[joint];
  int c, all = rows->columns + 2;
  double *known = raw_column(space, joint, KNOWN(rows->columns));
  double *measured = raw_column(space, joint, EFFORT(rows->columns));
  size_t i;

  for (c = 0; c < all; c++) {
    double *to = rows_column(rows, c);
    if (c == KNOWN(rows->columns))
      for (i = 0; i < block->n; i++) known[i] = measured[i] - known[i];
    tl_grid_resample(block->t_s, raw_column(space, joint, c), block->n,
                     span->segment_begin_s + (double)g.first * r->step_s, r->step_s, to, g.n);
    tl_lowpass_zero_phase(&r->lowpass, to, g.n);
    memmove(to, to + (g.from - g.first), (g.to - g.from) * sizeof *to);
    if (c == KNOWN(rows->columns))
      for (i = 0; i < block->n; i++) known[i] = measured[i] - known[i];
  }
  rows->n = g.to - g.from;
  rows->begin_s = span->segment_begin_s + (double)g.from * r->step_s;
}

tl_status tl_regression_block(const tl_regression *r, const tl_block *block, const tl_span *span,
                              tl_regression_space *space) {
  grid_part g;
  int j;
  tl_status status;

  if (!span) return TL_ERR_ARGUMENT;
  status = tl_regression_motion(r, block, space);
  if (status != TL_OK) return status;
  g = part_of(r, block, span);
  if (g.n > space->grid) return TL_ERR_WORKSPACE;
  for (j = 0; j < tl_joint_count(&r->model); j++) {
    space->rows[j].n = 0;
    if (g.from >= g.to) continue;
    grid_rows(r, span, block, j, g, space);
    mark_rows(r, span, block, j, g, space);
  }
  return TL_OK;
}

/* ---- what is done with rows ---------------------------------------------- */

void tl_rows_fold(const tl_rows *rows, const double *weight, double *scratch, tl_factor *factor) {
  size_t kept = 0, k;
  int c;

  for (k = 0; k < rows->n; k++) kept += rows->kind[k] == TL_ROW_SCORED;
  for (c = 0; c <= rows->columns; c++) {
    const double *from = rows_column(rows, c);
    double *to = scratch + (size_t)c * kept;
    for (k = 0; k < rows->n; k++)
      if (rows->kind[k] == TL_ROW_SCORED) *to++ = weight ? weight[k] * from[k] : from[k];
  }
  if (kept) tl_factor_add(factor, scratch, kept, kept);
}

double *tl_rows_column(const tl_rows *rows, int c) {
  return rows_column(rows, c);
}

double tl_rows_measured(const tl_rows *rows, size_t k) {
  return rows_column(rows, EFFORT(rows->columns))[k];
}

double tl_rows_residual(const tl_rows *rows, const double *base, size_t k) {
  double sum = rows_column(rows, rows->columns)[k];
  int c;

  for (c = 0; c < rows->columns; c++) sum -= rows_column(rows, c)[k] * base[rows->index[c]];
  return sum;
}
