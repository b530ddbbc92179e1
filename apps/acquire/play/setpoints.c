/* setpoints.c: reading set-points. */
#include "setpoints.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/decimal.h"
#include "common/text_file.h"

enum { COLUMNS = 7, REQUIRED = 3, FIELDS = 64, MOST_ROWS = 10000000 };
static const double SHORTEST_S = 0.0002,
                    LONGEST_S = 0.05; /* between rows: the bus's load; what a bench bridges */

static const char *const column[COLUMNS] = {
    "time_s",         "knee_rad",       "ankle_rad", "knee_velocity_rad_s", "ankle_velocity_rad_s",
    "knee_torque_Nm", "ankle_torque_Nm"};

/* a file while it is read */
struct reading {
  struct setpoints *t;
  size_t line, room;
  int place[COLUMNS]; /* field of each column, -1 none; all unset until the header */
  int header_seen;
  struct app_error *error;
};

static int refuse(const struct reading *r, const char *what) {
  return app_fail(r->error, APP_BAD_INPUT, "%s: line %zu: %s", r->t->path, r->line, what);
}

/* ---- header ------------------------------------------------------------------------- */

static int take_header(struct reading *r, const char *at, const char *end) {
  for (int c = 0; c < COLUMNS; c++) r->place[c] = -1;
  for (int field = 0; at <= end && field < FIELDS; field++) {
    const char *comma = memchr(at, ',', (size_t)(end - at));
    const size_t n = (size_t)((comma ? comma : end) - at);
    for (int c = 0; c < COLUMNS; c++)
      if (strlen(column[c]) == n && memcmp(column[c], at, n) == 0) r->place[c] = field;
    if (!comma) break;
    at = comma + 1;
  }
  for (int c = 0; c < REQUIRED; c++)
    if (r->place[c] < 0)
      return app_fail(r->error, APP_BAD_INPUT, "%s: column %s is missing", r->t->path, column[c]);
  r->header_seen = 1;
  return 0;
}

/* ---- rows ---------------------------------------------------------------------------- */

static int make_room(struct reading *r) {
  struct setpoints *t = r->t;
  if (t->rows < r->room) return 0;
  if (t->rows >= MOST_ROWS) return refuse(r, "more rows than can be played");
  r->room = r->room ? 2 * r->room : 4096;
  struct setpoint *more = realloc(t->row, r->room * sizeof *more);
  if (!more) return app_fail(r->error, APP_FAILED, "out of memory");
  t->row = more;
  return 0;
}

static int check_time(const struct reading *r) {
  const struct setpoint *last = &r->t->row[r->t->rows - 1];
  if (r->t->rows < 2) return 0;
  const double step = last->t_s - last[-1].t_s;
  if (!(step > 0.0)) return refuse(r, "time_s does not rise");
  if (step < SHORTEST_S) return refuse(r, "less than 0.2 ms after the row before");
  if (step > LONGEST_S)
    return refuse(r, "more than 50 ms after the row before: the bench would hold in between");
  return 0;
}

static int store(struct reading *r, const double value[COLUMNS]) {
  if (make_room(r) != 0) return -1;
  struct setpoint *row = &r->t->row[r->t->rows++];
  row->t_s = value[0];
  for (int j = 0; j < SETPOINT_JOINTS; j++) {
    row->joint[j].q_rad = value[1 + j];
    row->joint[j].v_rad_s = value[3 + j];
    row->joint[j].torque_Nm = value[5 + j];
  }
  return check_time(r);
}

static int take_row(struct reading *r, const char *at, const char *end) {
  double value[COLUMNS] = {0};
  int found = 0;
  for (int field = 0; at <= end && field < FIELDS; field++) {
    const char *comma = memchr(at, ',', (size_t)(end - at)), *stop = comma ? comma : end;
    for (int c = 0; c < COLUMNS; c++) {
      const char *behind;
      if (r->place[c] != field) continue;
      if (decimal_parse(at, &value[c], &behind) != DECIMAL_OK || behind != stop)
        return app_fail(r->error, APP_BAD_INPUT, "%s: line %zu: column %s is not a number", r->t->path,
                        r->line, column[c]);
      found++;
    }
    if (!comma) break;
    at = comma + 1;
  }
  int wanted = 0;
  for (int c = 0; c < COLUMNS; c++) wanted += r->place[c] >= 0;
  return found == wanted ? store(r, value) : refuse(r, "fewer fields than the header");
}

static int take_line(struct reading *r, const char *at, const char *end) {
  r->line++;
  if (end > at && end[-1] == '\r') end--;
  if (at == end || *at == '#') return 0;
  return r->header_seen ? take_row(r, at, end) : take_header(r, at, end);
}

static int take_block(struct reading *r, const struct text_block *block) {
  const char *at = block->text, *end = block->text + block->length;
  if (block->endless) return refuse(r, "a line without end");
  while (at < end) {
    const char *newline = memchr(at, '\n', (size_t)(end - at));
    if (!newline) break;
    if (take_line(r, at, newline) != 0) return -1;
    at = newline + 1;
  }
  return 0;
}

/* without a column for it: central differences, one-sided at the ends */
static void fill_velocity(struct setpoints *t, int joint) {
  for (size_t i = 0; i < t->rows; i++) {
    const struct setpoint *a = &t->row[i ? i - 1 : 0], *b = &t->row[i + 1 < t->rows ? i + 1 : i];
    t->row[i].joint[joint].v_rad_s = (b->joint[joint].q_rad - a->joint[joint].q_rad) / (b->t_s - a->t_s);
  }
}

int setpoints_read(struct setpoints *t, const char *path, struct app_error *error) {
  static struct text_block block;
  struct reading r = {.t = t, .error = error};
  int more;
  memset(t, 0, sizeof *t);
  t->path = path;
  struct text_file *file = text_file_open(path, error);
  if (!file) return -1;
  while ((more = text_file_read(file, &block, error)) > 0)
    if (take_block(&r, &block) != 0) break;
  text_file_close(file);
  if (more != 0) return -1;
  if (t->rows < 2) return app_fail(error, APP_BAD_INPUT, "%s: fewer than two rows", path);
  for (int j = 0; j < SETPOINT_JOINTS; j++)
    if (r.place[3 + j] < 0) fill_velocity(t, j);
  return 0;
}

void setpoints_free(struct setpoints *t) {
  free(t->row);
  t->row = NULL;
}
