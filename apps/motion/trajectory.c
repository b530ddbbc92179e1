/* trajectory.c: see trajectory.h. */
#include "trajectory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/decimal.h"
#include "common/text_file.h"

#define COLUMNS (TL_MAX_JOINTS + 1) /* time, then the joints */
#define MAX_FIELDS 256
#define NAME_SIZE 32
#define FIRST_ROWS 4096

/* The file on its way in. */
struct reader {
  struct trajectory *out;
  size_t room, line, fields;
  int column[MAX_FIELDS]; /* of each field, -1: not known */
  char name[COLUMNS][NAME_SIZE];
  int columns;
};

/* ---- the header -------------------------------------------------------------------- */

static void choose_names(struct reader *r, const tl_model *m) {
  const char *unit = m->plant == TL_PLANT_SLIDER ? "m" : "rad";

  r->columns = 1 + tl_joint_count(m);
  snprintf(r->name[0], NAME_SIZE, "time_s");
  for (int c = 1; c < r->columns; c++)
    snprintf(r->name[c], NAME_SIZE, "%s_%s", tl_joint_name(m, c - 1), unit);
}

static const char *field_end(const char *c, const char *end) {
  const char *comma = memchr(c, ',', (size_t)(end - c));

  return comma ? comma : end;
}

static int is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

static int find_column(const struct reader *r, const char *begin, const char *end) {
  while (begin < end && is_blank(*begin)) begin++;
  while (end > begin && is_blank(end[-1])) end--;
  for (int c = 0; c < r->columns; c++)
    if (strlen(r->name[c]) == (size_t)(end - begin) && memcmp(r->name[c], begin, (size_t)(end - begin)) == 0)
      return c;
  return -1;
}

static int take_header(struct reader *r, const char *c, const char *end, struct app_error *error) {
  int found[COLUMNS] = {0};

  for (;; c++) {
    const char *stop = field_end(c, end);
    int column = find_column(r, c, stop);
    if (r->fields == MAX_FIELDS)
      return app_fail(error, APP_BAD_INPUT, "%s:%zu: more than %d columns", r->out->path, r->line,
                      MAX_FIELDS);
    r->column[r->fields++] = column;
    if (column >= 0 && found[column]++)
      return app_fail(error, APP_BAD_INPUT, "%s:%zu: column %s stands twice in the header", r->out->path,
                      r->line, r->name[column]);
    c = stop;
    if (c == end) break;
  }
  for (int k = 0; k < r->columns; k++)
    if (!found[k])
      return app_fail(error, APP_BAD_INPUT, "%s:%zu: missing column: %s", r->out->path, r->line, r->name[k]);
  if (r->fields > (size_t)r->columns)
    app_note("%s: columns other than time and joint angles are not read", r->out->path);
  return 0;
}

/* ---- the rows ---------------------------------------------------------------------- */

static int grow_column(double **column, size_t room) {
  double *more = realloc(*column, room * sizeof *more);

  if (more) *column = more;
  return more ? 0 : -1;
}

static int grow(struct reader *r, struct app_error *error) {
  const size_t room = r->room ? 2 * r->room : FIRST_ROWS;
  int failed = grow_column(&r->out->t_s, room);

  for (int j = 0; j < r->out->joints; j++) failed |= grow_column(&r->out->q[j], room);
  if (failed) return app_fail(error, APP_FAILED, "out of memory");
  r->room = room;
  return 0;
}

static int take_field(const struct reader *r, size_t field, const char *c, const char *end, double *value,
                      struct app_error *error) {
  const char *rest, *name = r->name[r->column[field]];
  char shown[60];

  while (c < end && is_blank(*c)) c++;
  while (end > c && is_blank(end[-1])) end--;
  app_printable(shown, sizeof shown, c, (size_t)(end - c));
  const enum decimal_status status = c < end ? decimal_parse(c, value, &rest) : DECIMAL_NOT_A_NUMBER;
  if (status == DECIMAL_OK && rest == end) return 0;
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: %s: '%s' is %s", r->out->path, r->line, name, shown,
                  status == DECIMAL_NOT_FINITE ? "not finite" : "not a number");
}

static int keep_row(struct reader *r, const double value[COLUMNS], struct app_error *error) {
  struct trajectory *t = r->out;

  if (t->rows > 0 && !(value[0] > t->t_s[t->rows - 1]))
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: time_s does not rise from %.15g to %.15g", t->path,
                    r->line, t->t_s[t->rows - 1], value[0]);
  if (t->rows == r->room && grow(r, error) != 0) return -1;
  t->t_s[t->rows] = value[0];
  for (int j = 0; j < t->joints; j++) t->q[j][t->rows] = value[j + 1];
  t->rows++;
  return 0;
}

static int take_row(struct reader *r, const char *c, const char *end, struct app_error *error) {
  double value[COLUMNS];
  size_t field = 0;

  for (;; c++) {
    const char *stop = field_end(c, end);
    if (field < r->fields && r->column[field] >= 0 &&
        take_field(r, field, c, stop, &value[r->column[field]], error) != 0)
      return -1;
    field++;
    c = stop;
    if (c == end) break;
  }
  if (field != r->fields)
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: %zu fields, the header has %zu", r->out->path, r->line,
                    field, r->fields);
  return keep_row(r, value, error);
}

static int take_line(struct reader *r, const char *c, const char *end, struct app_error *error) {
  const char *first = c;

  while (first < end && is_blank(*first)) first++;
  if (*c == '#' || first == end) return 0;
  return r->fields ? take_row(r, c, end, error) : take_header(r, c, end, error);
}

static int take_lines(struct reader *r, struct text_file *file, struct text_block *block,
                      struct app_error *error) {
  int more;

  while ((more = text_file_read(file, block, error)) > 0) {
    const char *c = block->text, *end = c + block->length;
    if (block->endless)
      return app_fail(error, APP_BAD_INPUT, "%s:%zu: not a line of text", r->out->path, r->line + 1);
    while (c < end) {
      const char *newline = memchr(c, '\n', (size_t)(end - c));
      r->line++;
      if (take_line(r, c, newline, error) != 0) return -1;
      c = newline + 1;
    }
  }
  return more;
}

static int read_file(struct reader *r, struct app_error *error) {
  struct text_file *file = text_file_open(r->out->path, error);
  struct text_block *block = file ? malloc(sizeof *block) : NULL;
  int result = -1;

  if (block)
    result = take_lines(r, file, block, error);
  else if (file)
    app_fail(error, APP_FAILED, "out of memory");
  free(block);
  text_file_close(file);
  if (result == 0 && r->out->rows < TRAJECTORY_MIN_ROWS)
    return app_fail(error, APP_BAD_INPUT, "%s: %zu rows, expected at least %d", r->out->path, r->out->rows,
                    TRAJECTORY_MIN_ROWS);
  return result;
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
  double *upper = malloc(t->rows * sizeof *upper);
  const double first_s = t->t_s[0];

  if (!upper) return app_fail(error, APP_FAILED, "out of memory");
  for (size_t i = 0; i < t->rows; i++) t->t_s[i] -= first_s;
  for (int j = 0; j < t->joints; j++) {
    t->bend[j] = malloc(t->rows * sizeof *t->bend[j]);
    if (!t->bend[j]) break;
    bend_spline(t, t->q[j], t->bend[j], upper);
  }
  free(upper);
  return t->bend[t->joints - 1] ? 0 : app_fail(error, APP_FAILED, "out of memory");
}

int trajectory_read(const char *path, const tl_model *model, struct trajectory *out,
                    struct app_error *error) {
  struct reader r = {.out = out};

  memset(out, 0, sizeof *out);
  out->path = path;
  out->joints = tl_joint_count(model);
  choose_names(&r, model);
  if (read_file(&r, error) == 0 && make_spline(out, error) == 0) return 0;
  trajectory_free(out);
  return -1;
}

void trajectory_free(struct trajectory *t) {
  free(t->t_s);
  for (int j = 0; j < TL_MAX_JOINTS; j++) {
    free(t->q[j]);
    free(t->bend[j]);
  }
  memset(t, 0, sizeof *t);
}

/* ---- along it ---------------------------------------------------------------------- */

double trajectory_length_s(const struct trajectory *t) {
  return t->t_s[t->rows - 1];
}

/* the row at or before t_s, which lies between the ends; not the last row */
static size_t row_before(const struct trajectory *t, double t_s) {
  size_t low = 0, high = t->rows - 1;

  while (high - low > 1) {
    const size_t middle = low + (high - low) / 2;
    if (t->t_s[middle] <= t_s)
      low = middle;
    else
      high = middle;
  }
  return low;
}

void trajectory_at(const struct trajectory *t, double t_s, tl_motion *motion) {
  const double end_s = trajectory_length_s(t), at = t_s < 0.0 ? 0.0 : t_s > end_s ? end_s : t_s;
  const int rests = t_s <= 0.0 || t_s >= end_s;
  const size_t i = row_before(t, at);
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
