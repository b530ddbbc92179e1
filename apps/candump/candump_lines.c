/* candump_lines.c: the marks of a line first, then what stands between them. */
#include "candump_lines.h"

#include <string.h>

enum {
  LONGEST = 511 /* a line with more characters holds no frame */,
  CLASSIC = 8,
  ID = 3,
  LONG_ID = 8,
  MOST_SECONDS = 11
};
enum { NS_DIGITS = 9, LAST_CLOSE = 29, NS_PER_S = 1000000000 };

static const uint32_t EXTENDED = 1U << 31, ERROR = 0x20000000;

enum kind { DATA, REMOTE, ERROR_FRAME, NONE };

struct marks {
  size_t dot, close, space, mark, end; /* characters from the line's first */
  int follows;                         /* the mark: 1 a remote frame, 2 CAN FD, else 0 */
  int directed;                        /* there is a direction at the end */
};

struct frame {
  int64_t time_ns;
  uint32_t identifier;
  size_t length;
  uint8_t data[CANDUMP_BYTES];
};

/* ---- one line ------------------------------------------------------------------------ */

static size_t place_of(const char *text, size_t from, size_t end, char what) {
  const char *found = from < end ? memchr(text + from, what, end - from) : NULL;
  return found ? (size_t)(found - text) : end;
}

static int find_marks(const char *text, size_t n, struct marks *m) {
  m->end = n;
  m->dot = place_of(text, 0, n, '.');
  m->close = place_of(text, 0, n, ')');
  m->space = place_of(text, m->close + 2, n, ' ');
  m->mark = place_of(text, m->space, n, '#');
  if (m->dot < 2 || m->dot > MOST_SECONDS + 1 || m->close < m->dot + 2 || m->close > m->dot + NS_DIGITS + 1)
    return -1;
  if (m->close > LAST_CLOSE || m->space <= m->close + 2 || m->mark <= m->space || m->mark >= n) return -1;
  const char behind = m->mark + 1 < n ? text[m->mark + 1] : '\0';
  m->follows = behind == 'R' ? 1 : behind == '#' ? 2 : 0;
  m->directed = text[n - 2] == ' ';
  return text[0] == '(' && text[m->close + 1] == ' ' ? 0 : -1;
}

static int whole_of(const char *text, size_t from, size_t end, int64_t *value) {
  *value = 0;
  for (size_t k = from; k < end; k++) {
    if (text[k] < '0' || text[k] > '9') return -1;
    *value = 10 * *value + (text[k] - '0');
  }
  return 0;
}

static int take_stamp(const char *text, const struct marks *m, struct frame *f) {
  int64_t seconds, fraction;
  if (whole_of(text, 1, m->dot, &seconds) != 0 || whole_of(text, m->dot + 1, m->close, &fraction) != 0)
    return -1;
  if (seconds >= INT64_MAX / NS_PER_S) return -1;
  for (size_t digits = m->close - m->dot - 1; digits < NS_DIGITS; digits++) fraction *= 10;
  f->time_ns = seconds * NS_PER_S + fraction;
  return 0;
}

static int hex_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const char lower = (char)(c | ' ');
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

static int take_identifier(const char *text, const struct marks *m, struct frame *f) {
  const size_t n = m->mark - m->space - 1;
  f->identifier = 0;
  if (n != ID && n != LONG_ID) return -1;
  for (size_t k = m->space + 1; k < m->mark; k++) {
    const int digit = hex_of(text[k]);
    if (digit < 0) return -1;
    f->identifier = f->identifier << 4 | (uint32_t)digit;
  }
  if (n == LONG_ID && !(f->identifier & ERROR)) f->identifier |= EXTENDED;
  return n == LONG_ID || f->identifier < 0x800 ? 0 : -1;
}

static int take_data(const char *text, const struct marks *m, struct frame *f) {
  const size_t skipped = m->follows == 2 ? 2 : 0, most = m->follows == 2 ? CANDUMP_BYTES : CLASSIC;
  const size_t begin = m->mark + 1 + skipped, end = m->end - (m->directed ? 2 : 0),
               n = end > begin ? end - begin : 0;
  f->length = n / 2;
  if (n % 2 || f->length > most) return -1;
  for (size_t k = 0; k < f->length; k++) {
    const int high = hex_of(text[begin + 2 * k]), low = hex_of(text[begin + 2 * k + 1]);
    if (high < 0 || low < 0) return -1;
    f->data[k] = (uint8_t)(high << 4 | low);
  }
  return 0;
}

static enum kind parse(const char *text, size_t n, struct marks *m, struct frame *f) {
  if (n < CANDUMP_SHORTEST || n >= LONGEST || find_marks(text, n, m) != 0) return NONE;
  if (take_stamp(text, m, f) != 0 || take_identifier(text, m, f) != 0) return NONE;
  if (m->follows == 1) return m->end - (m->directed ? 2 : 0) <= m->mark + 3 ? REMOTE : NONE;
  if (take_data(text, m, f) != 0) return NONE;
  return m->mark - m->space - 1 == LONG_ID && f->identifier & ERROR ? ERROR_FRAME : DATA;
}

/* ---- its columns ----------------------------------------------------------------------- */

/* Interfaces are numbered by the layout of their lines, then by name; so the numbers do not depend on who was first. */
static uint64_t order_of(const struct marks *m) {
  uint64_t order = (uint64_t)m->follows + (m->directed ? 4 : 0);
  const size_t place[] = {m->end, m->dot, m->close, m->space, m->mark};
  for (size_t k = 0; k < sizeof place / sizeof *place; k++) order = order << 9 | place[k];
  return order;
}

static int is_named(const struct candump_lines *b, const struct candump_name *a, size_t at, size_t n) {
  return a->n == n && memcmp(b->text + a->at, b->text + at, n) == 0;
}

static int64_t name_of(struct candump_lines *b, const struct marks *m, int64_t likely) {
  size_t n = m->space - m->close - 2;
  const size_t at = b->begin + m->close + 2;
  const uint64_t order = order_of(m);
  while (n && !b->text[at + n - 1]) n--;
  int64_t k = likely < b->names && is_named(b, &b->found[likely], at, n) ? likely : 0;
  while (k < b->names && !is_named(b, &b->found[k], at, n)) k++;
  if (k == CANDUMP_NAMES) return -1;
  if (k == b->names) b->found[b->names++] = (struct candump_name){at, n, order};
  if (order < b->found[k].least) b->found[k].least = order;
  return k;
}

static void add(struct candump_lines *b, const struct frame *f, int64_t name) {
  const int64_t k = b->frames++;
  b->time_ns[k] = f->time_ns;
  b->identifier[k] = f->identifier;
  b->line[k] = b->lines;
  b->name[k] = (uint16_t)name;
  b->length[k] = (uint8_t)f->length;
  memcpy(b->data + CANDUMP_BYTES * k, f->data, f->length);
  if ((int64_t)f->length > b->widest) b->widest = (int64_t)f->length;
}

static int is_blank(const char *text, size_t n) {
  while (n && (text[n - 1] == ' ' || (text[n - 1] >= '\t' && text[n - 1] <= '\r'))) n--;
  return n == 0;
}

int candump_lines_read(struct candump_lines *b) {
  struct marks m;
  struct frame f;
  for (int64_t name = 0; b->at < b->size;) {
    b->begin = b->at;
    b->end = place_of(b->text, b->begin, b->size, '\n');
    b->at = b->end + 1;
    b->lines++;
    const char *line = b->text + b->begin;
    const size_t n = b->end - b->begin;
    const enum kind kind = parse(line, n && line[n - 1] == '\r' ? n - 1 : n, &m, &f);
    if (kind == NONE && !is_blank(line, n)) return 1;
    if (kind == NONE) continue;
    name = name_of(b, &m, name);
    if (name < 0) return -1;
    b->remote += kind == REMOTE;
    b->errors += kind == ERROR_FRAME;
    if (kind == DATA) add(b, &f, name);
  }
  return 0;
}
