/* recording_row.c: one line of a recording as numbers. */
#include <math.h>
#include <string.h>

#include "common/decimal.h"
#include "recording_layout.h"

/* beyond this a number is no time [s], angle, current or torque; products of such numbers overflow */
static double largest(const struct layout *layout, int slot) {
  return layout->channel[slot] == TL_CHANNEL_TIME ? 1e12 : 1e9;
}

const char *layout_row(const struct layout *layout, const char *c, double *row) {
  const size_t last = layout->fields - 1;
  for (size_t i = 0; i <= last; i++) {
    const int slot = layout->slot[i];
    if (slot < 0) {
      while (*c != ',' && *c != '\n') c++;
    } else if (decimal_parse_padded(c, &row[slot], &c) != DECIMAL_OK ||
               fabs(row[slot]) > largest(layout, slot))
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
static int read_field(const struct layout *layout, struct field field, int slot, size_t line, double *x,
                      struct app_error *error) {
  char text[48];
  const char *end, *name = tl_channel_name(layout->channel[slot]);
  const size_t length = (size_t)(field.end - field.begin);
  if (length == 0)
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: %s: the field is empty, expected a number", layout->path,
                    line, name);
  const enum decimal_status status = decimal_parse(field.begin, x, &end);
  app_printable(text, sizeof text, field.begin, length);
  if (status == DECIMAL_OK && end == field.end) {
    if (fabs(*x) <= largest(layout, slot)) return 0;
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: %s: '%s' is beyond anything physical, expected at most %g",
                    layout->path, line, name, text, largest(layout, slot));
  }
  if (status == DECIMAL_NOT_FINITE && end == field.end)
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: %s: '%s' is not a finite number", layout->path, line, name,
                    text);
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: %s: '%s' is not a number", layout->path, line, name, text);
}

static int wrong_count(const struct layout *layout, size_t found, size_t line, int cut,
                       struct app_error *error) {
  if (cut && found < layout->fields)
    return app_fail(error, APP_BAD_INPUT,
                    "%s:%zu: truncated: the file ends within this line (%zu of %zu fields)", layout->path,
                    line, found, layout->fields);
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: %zu fields, expected %zu as in the header", layout->path,
                  line, found, layout->fields);
}

int layout_row_strict(const struct layout *layout, const char *c, const char *end, size_t line, int cut,
                      double *row, struct app_error *error) {
  const size_t found = count_fields(c, end);
  if (found == 1 && layout->fields > 1 && layout_field(c, end, &(const char *){NULL}).begin == end)
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: a blank line amid the samples", layout->path, line);
  if (found != layout->fields) return wrong_count(layout, found, line, cut, error);
  for (size_t i = 0; i < layout->fields; i++) {
    const struct field field = layout_field(c, end, &c);
    const int slot = layout->slot[i];
    if (slot >= 0 && read_field(layout, field, slot, line, &row[slot], error) != 0) return -1;
    if (c < end) c++;
  }
  return 0;
}
