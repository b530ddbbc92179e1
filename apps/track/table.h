/* table.h: columns of numbers from a CSV file, by name.
 *
 *     static const char *const names[] = {"time_s", "shank_rad"};
 *     struct table table;
 *     if (table_read("track.csv", names, 2, 2, &table, &error) != 0) return app_exit(&error);
 *     ... table.column[1][row] for row < table.rows
 *     table_free(&table);
 */
#ifndef TRACK_TABLE_H
#define TRACK_TABLE_H

#include "common/csv.h"

struct table {
  size_t rows, capacity, columns, needed;
  double *column[CSV_MAX_COLUMNS]; /* NULL for one that the file does not have */
};

/* The first `needed` of n names must be there, and the first must rise. 0, or -1 with file, line and what is wrong. */
int table_read(const char *path, const char *const *names, size_t n, size_t needed, struct table *table,
               struct app_error *error);
void table_free(struct table *table);

#endif
