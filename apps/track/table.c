/* table.c: see table.h. */
#include "track/table.h"

#include <stdlib.h>
#include <string.h>

static int grow(struct table *table, struct app_error *error) {
  const size_t more = table->capacity ? 2 * table->capacity : 4096;
  for (size_t c = 0; c < table->columns; c++) {
    double *moved = realloc(table->column[c], more * sizeof *moved);
    if (!moved) return app_fail(error, APP_FAILED, "out of memory");
    table->column[c] = moved;
  }
  table->capacity = more;
  return 0;
}

static int take_header(const struct csv_lines *lines, void *context, struct app_error *error) {
  const struct table *table = context;
  for (size_t c = 0; c < table->needed; c++)
    if (lines->header->place_of[c] < 0)
      return csv_missing(lines->header, lines->line, lines->header->name[c], NULL, error);
  return 0;
}

static int take_row(const struct csv_lines *lines, const double *row, void *context,
                    struct app_error *error) {
  struct table *table = context;
  if (table->rows == table->capacity && grow(table, error) != 0) return -1;
  for (size_t c = 0; c < table->columns; c++) {
    const int place = lines->header->place_of[c];
    table->column[c][table->rows] = place < 0 ? 0.0 : row[place];
  }
  const double *t = table->column[0] + table->rows;
  if (table->rows > 0 && !(t[0] > t[-1]))
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: %s must rise, found %g after %g", lines->header->path,
                    lines->line, lines->header->name[0], t[0], t[-1]);
  table->rows++;
  return 0;
}

int table_read(const char *path, const char *const *names, size_t n, size_t needed, struct table *table,
               struct app_error *error) {
  static const struct csv_visitor visitor = {take_header, take_row};
  struct csv_header *header = calloc(1, sizeof *header);
  memset(table, 0, sizeof *table);
  table->columns = n;
  table->needed = needed;
  if (!header) return app_fail(error, APP_FAILED, "out of memory");
  header->path = path;
  header->name = names;
  header->names = n;
  const int result = csv_read(header, &visitor, table, error);
  for (size_t c = 0; c < n; c++)
    if (header->place_of[c] < 0 || result != 0) {
      free(table->column[c]);
      table->column[c] = NULL;
    }
  free(header);
  return result;
}

void table_free(struct table *table) {
  for (size_t c = 0; c < table->columns; c++) free(table->column[c]);
  memset(table, 0, sizeof *table);
}
