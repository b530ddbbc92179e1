/* csv_row.c: one line as numbers. */
#include <math.h>
#include <string.h>

#include "csv.h"
#include "csv_field.h"
#include "decimal.h"

const char *csv_plain_row(const struct csv_header *h, const char *c, double *row) {
  const size_t last = h->fields - 1;
  for (size_t i = 0; i <= last; i++) {
    const int place = h->place[i];
    if (place < 0) {
      while (*c != ',' && *c != '\n') c++;
    } else if (decimal_parse_padded(c, &row[place], &c) != DECIMAL_OK || fabs(row[place]) > h->largest[place])
      return NULL;
    if (i < last && *c++ != ',') return NULL;
  }
  if (*c == '\r') c++;
  return *c == '\n' ? c + 1 : NULL;
}

static size_t count_fields(const char *c, const char *end) {
  size_t n = 1;
  for (; c < end; c++) n += *c == ',';
  return n;
}

/* one field as a number, or the reason why not */
static int read_field(const struct csv_header *h, struct csv_field field, int place, size_t line, double *x,
                      struct app_error *error) {
  char text[48];
  const char *end, *name = h->name[h->column[place]];
  const size_t length = (size_t)(field.end - field.begin);
  if (length == 0)
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: %s: the field is empty, expected a number%s", h->path,
                    line, name, csv_advice(h));
  const enum decimal_status status = decimal_parse(field.begin, x, &end);
  app_printable(text, sizeof text, field.begin, length);
  if (status == DECIMAL_OK && end == field.end) {
    if (fabs(*x) <= h->largest[place]) return 0;
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: %s: '%s' is beyond anything physical, expected at most %g",
                    h->path, line, name, text, h->largest[place]);
  }
  const int missing = status == DECIMAL_NOT_FINITE && end == field.end;
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: %s: '%s' is not a %snumber%s", h->path, line, name, text,
                  missing ? "finite " : "", missing ? csv_advice(h) : "");
}

static int wrong_count(const struct csv_header *h, size_t found, size_t line, int cut,
                       struct app_error *error) {
  if (cut && found < h->fields)
    return app_fail(error, APP_BAD_INPUT,
                    "%s:%zu: truncated: the file ends within this line (%zu of %zu fields)", h->path, line,
                    found, h->fields);
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: %zu fields, expected %zu as in the header", h->path, line,
                  found, h->fields);
}

/* The line [c, end), blanks around fields allowed, with the error's text. */
static int strict_row(const struct csv_header *h, const char *c, const char *end, size_t line, int cut,
                      double *row, struct app_error *error) {
  const size_t found = count_fields(c, end);
  if (found != h->fields) return wrong_count(h, found, line, cut, error);
  for (size_t i = 0; i < h->fields; i++) {
    const struct csv_field field = csv_field(c, end, ',', &c);
    const int place = h->place[i];
    if (place >= 0 && read_field(h, field, place, line, &row[place], error) != 0) return -1;
    if (c < end) c++;
  }
  return 0;
}

int csv_blank(const struct csv_lines *lines, struct app_error *error) {
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: a blank line amid the samples%s", lines->header->path,
                  lines->blank_line, csv_advice(lines->header));
}

static int is_blank_line(const char *c, const char *end) {
  while (c < end && csv_is_blank(*c)) c++;
  return c == end;
}

int csv_take(struct csv_lines *lines, const char *line, const char *newline, int cut, double *row,
             struct app_error *error) {
  struct csv_header *h = lines->header;
  const char *end = newline > line && newline[-1] == '\r' ? newline - 1 : newline;
  if (*line == '#') return CSV_NOTHING;
  if (is_blank_line(line, end)) {
    if (h->fields && !lines->blank_line) lines->blank_line = lines->line;
    return CSV_NOTHING;
  }
  if (!h->fields) return csv_header_line(h, line, end, lines->line, error) == 0 ? CSV_HEADER : -1;
  if (lines->blank_line) return csv_blank(lines, error);
  return strict_row(h, line, end, lines->line, cut, row, error) == 0 ? CSV_ROW : -1;
}
