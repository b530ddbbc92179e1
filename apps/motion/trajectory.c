/* trajectory.c: see trajectory.h. */
#include "trajectory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/csv.h"
#include "common/interval.h"

#define NAME_SIZE 40
#define FIRST_ROWS 4096

/* The file on its way in. Columns are the time, then every joint's position, speed and torque. */
struct reader {
  struct trajectory *out;
  const struct trajectory_steps *steps;
  size_t room;
  char text[TRAJECTORY_COLUMNS][NAME_SIZE];
  const char *name[TRAJECTORY_COLUMNS];
};

/* ---- the columns ------------------------------------------------------------------- */

static void choose_names(struct reader *r, const tl_model *m) {
  const tl_facts *f = tl_plant_facts(m->plant);
  char speed[16], torque[24];
  const char *const quantity[] = {f->coordinate_unit, speed, torque};

  snprintf(speed, sizeof speed, "velocity_%s_s", f->coordinate_unit);
  snprintf(torque, sizeof torque, "%s_%s", f->torque_name, f->torque_unit);
  snprintf(r->text[0], NAME_SIZE, "time_s");
  for (int q = 0; q < TRAJECTORY_QUANTITIES; q++)
    for (int j = 0; j < f->joints; j++)
      snprintf(r->text[1 + q * f->joints + j], NAME_SIZE, "%s_%s", f->joint[j], quantity[q]);
  for (int c = 0; c < 1 + TRAJECTORY_QUANTITIES * f->joints; c++) r->name[c] = r->text[c];
}

static int take_header(const struct csv_lines *lines, void *context, struct app_error *error) {
  const struct reader *r = context;
  const struct csv_header *h = lines->header;
  struct csv_list missing = {"", 0};

  for (int c = 0; c <= r->out->joints; c++)
    if (h->place_of[c] < 0) csv_list_add(&missing, ", ", r->name[c]);
  return missing.used ? csv_missing(h, lines->line, missing.text, NULL, error) : 0;
}

/* ---- the rows ---------------------------------------------------------------------- */

static int grow(struct reader *r, const struct csv_header *h, struct app_error *error) {
  const size_t room = r->room ? 2 * r->room : FIRST_ROWS;

  for (size_t k = 0; k < h->width; k++) {
    double **column = &r->out->column[h->column[k]], *more = realloc(*column, room * sizeof *more);
    if (!more) return app_fail(error, APP_FAILED, "out of memory");
    *column = more;
  }
  r->room = room;
  return 0;
}

/* the step from the row before */
static int check_step(const struct reader *r, double from_s, double to_s, const struct csv_lines *lines,
                      struct app_error *error) {
  const char *path = lines->header->path;

  if (!(to_s > from_s))
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: time_s does not rise from %.15g to %.15g", path,
                    lines->line, from_s, to_s);
  if (!r->steps || (to_s - from_s >= r->steps->shortest_s && to_s - from_s <= r->steps->longest_s)) return 0;
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: time_s is %.6g s after the row before, expected %g to %g s",
                  path, lines->line, to_s - from_s, r->steps->shortest_s, r->steps->longest_s);
}

static int take_row(const struct csv_lines *lines, const double *row, void *context,
                    struct app_error *error) {
  struct reader *r = context;
  struct trajectory *t = r->out;
  const struct csv_header *h = lines->header;
  const double t_s = row[h->place_of[0]];

  if (t->rows > 0 && check_step(r, t->column[0][t->rows - 1], t_s, lines, error) != 0) return -1;
  if (t->rows == r->room && grow(r, h, error) != 0) return -1;
  for (size_t k = 0; k < h->width; k++) t->column[h->column[k]][t->rows] = row[k];
  t->rows++;
  return 0;
}

static int read_file(struct reader *r, struct app_error *error) {
  static const struct csv_visitor visitor = {take_header, take_row};
  struct trajectory *t = r->out;
  struct csv_header header = {
      .path = t->path, .name = r->name, .names = (size_t)(1 + TRAJECTORY_QUANTITIES * t->joints)};

  if (csv_read(&header, &visitor, r, error) != 0) return -1;
  if (header.unknown.used) app_note("%s: columns not known and not read: %s", t->path, header.unknown.text);
  t->t_s = t->column[0];
  for (int j = 0; j < t->joints; j++) t->q[j] = t->column[1 + j];
  return 0;
}

/* ---- the spline -------------------------------------------------------------------- */

/* Acceleration at the rows of the cubic spline with speed 0 at both ends: a tridiagonal system, forward and back.
 * `upper` is work of as many rows. */
static void bend_spline(const struct trajectory *t, const double *q, double *bend, double *upper) {
  double before = 0.0, rise_before = 0.0; /* of the step before: length, slope */

  for (size_t i = 0; i < t->rows; i++) {
    const int last = i + 1 == t->rows;
    const double step = last ? 0.0 : t->t_s[i + 1] - t->t_s[i];
    const double rise = last ? 0.0 : (q[i + 1] - q[i]) / step;
    const double lower = i ? upper[i - 1] : 0.0, known = i ? bend[i - 1] : 0.0;
    const double pivot = 2.0 * (before + step) - before * lower;
    upper[i] = step / pivot;
    bend[i] = (6.0 * (rise - rise_before) - before * known) / pivot;
    before = step;
    rise_before = rise;
  }
  for (size_t i = t->rows - 1; i-- > 0;) bend[i] -= upper[i] * bend[i + 1];
}

static int make_spline(struct trajectory *t, struct app_error *error) {
  double *upper;

  if (t->rows < TRAJECTORY_MIN_ROWS)
    return app_fail(error, APP_BAD_INPUT, "%s: %zu rows, expected at least %d", t->path, t->rows,
                    TRAJECTORY_MIN_ROWS);
  upper = malloc(t->rows * sizeof *upper);
  if (!upper) return app_fail(error, APP_FAILED, "out of memory");
  t->begin_s = t->t_s[0];
  for (size_t i = 0; i < t->rows; i++) t->t_s[i] -= t->begin_s;
  for (int j = 0; j < t->joints; j++) {
    t->bend[j] = malloc(t->rows * sizeof *t->bend[j]);
    if (!t->bend[j]) break;
    bend_spline(t, t->q[j], t->bend[j], upper);
  }
  free(upper);
  return t->bend[t->joints - 1] ? 0 : app_fail(error, APP_FAILED, "out of memory");
}

int trajectory_read(const char *path, const tl_model *model, const struct trajectory_steps *steps,
                    struct trajectory *out, struct app_error *error) {
  struct reader r = {.out = out, .steps = steps};

  memset(out, 0, sizeof *out);
  out->path = path;
  out->joints = tl_joint_count(model);
  choose_names(&r, model);
  if (read_file(&r, error) == 0 && make_spline(out, error) == 0) return 0;
  trajectory_free(out);
  return -1;
}

void trajectory_free(struct trajectory *t) {
  for (int c = 0; c < TRAJECTORY_COLUMNS; c++) free(t->column[c]);
  for (int j = 0; j < TL_MAX_JOINTS; j++) free(t->bend[j]);
  memset(t, 0, sizeof *t);
}

/* ---- along it ---------------------------------------------------------------------- */

double trajectory_length_s(const struct trajectory *t) {
  return t->t_s[t->rows - 1];
}

void trajectory_at(const struct trajectory *t, double t_s, tl_motion *motion) {
  const double end_s = trajectory_length_s(t), at = t_s < 0.0 ? 0.0 : t_s > end_s ? end_s : t_s;
  const int rests = t_s <= 0.0 || t_s >= end_s;
  const size_t i = interval_of(t->t_s, t->rows, at);
  const double step = t->t_s[i + 1] - t->t_s[i], x = at - t->t_s[i], y = step - x;

  memset(motion, 0, sizeof *motion);
  for (int j = 0; j < t->joints; j++) {
    const double *q = t->q[j] + i, *bend = t->bend[j] + i;
    const double from = q[0] / step - bend[0] * step / 6.0, to = q[1] / step - bend[1] * step / 6.0;
    motion->q[j] = (bend[0] * y * y * y + bend[1] * x * x * x) / (6.0 * step) + from * y + to * x;
    if (rests) continue;
    motion->v[j] = (bend[1] * x * x - bend[0] * y * y) / (2.0 * step) + to - from;
    motion->a[j] = (bend[0] * y + bend[1] * x) / step;
  }
}

/* ---- in other rows ----------------------------------------------------------------- */

static int allocate_rows(struct trajectory *t) {
  for (int c = 0; c <= t->joints; c++) {
    t->column[c] = malloc(t->rows * sizeof *t->column[c]);
    if (!t->column[c]) return -1;
  }
  t->t_s = t->column[0];
  for (int j = 0; j < t->joints; j++) t->q[j] = t->column[1 + j];
  return t->t_s ? 0 : -1;
}

int trajectory_resample(struct trajectory *t, double step_s, double rest_s, struct app_error *error) {
  struct trajectory fine = {.path = t->path, .joints = t->joints};
  tl_motion at;

  fine.rows = (size_t)ceil((trajectory_length_s(t) + 2.0 * rest_s) / step_s) + 1;
  if (allocate_rows(&fine) != 0) {
    trajectory_free(&fine);
    return app_fail(error, APP_FAILED, "out of memory");
  }
  for (size_t i = 0; i < fine.rows; i++) {
    const double t_s = (double)i * step_s - rest_s;
    trajectory_at(t, t_s, &at);
    fine.t_s[i] = t->begin_s + t_s;
    for (int j = 0; j < t->joints; j++) fine.q[j][i] = at.q[j];
  }
  if (make_spline(&fine, error) != 0) {
    trajectory_free(&fine);
    return -1;
  }
  trajectory_free(t);
  *t = fine;
  return 0;
}

/* ---- at its rows ------------------------------------------------------------------- */

static const double *column_of(const struct trajectory *t, int quantity, int joint) {
  return t->column[1 + quantity * t->joints + joint];
}

double trajectory_speed(const struct trajectory *t, size_t row, int joint) {
  const double *given = column_of(t, 1, joint);
  tl_motion motion;

  if (given) return given[row];
  trajectory_at(t, t->t_s[row], &motion);
  return motion.v[joint];
}

double trajectory_torque(const struct trajectory *t, size_t row, int joint) {
  const double *given = column_of(t, 2, joint);

  return given ? given[row] : 0.0;
}

int trajectory_orders_drives(const struct trajectory *t) {
  for (int j = 0; j < t->joints; j++)
    if (column_of(t, 1, j) || column_of(t, 2, j)) return 1;
  return 0;
}
