/* csv.h: comma-separated numbers, split in one place for every file that the programs read.
 *
 *     static const char *const name[] = {"time_s", "knee_rad"};
 *     struct csv_header header = {.path = path, .name = name, .names = 2};
 *     csv_read(&header, &(struct csv_visitor){check_header, take_row}, context, &error);
 *
 * The format. A header line with the columns' names in any order, then one line a row; comma separated, '.'
 * decimal. Lines that begin with '#' are comments. Blanks around a field, a byte order mark, \r\n and blank lines
 * before the header or at the end are accepted. Columns without a known name are not read.
 *
 * A row is its numbers in the order in which the header names the known columns: header.place_of[] says where each
 * name's number stands. Every fault is one line with file and line, and status 2.
 */
#ifndef CSV_H
#define CSV_H

#include <stddef.h>
#include <stdint.h>

#include "error.h"

#define CSV_MAX_FIELDS 1024
#define CSV_MAX_COLUMNS 32 /* names that can be known */
#define CSV_LIST 400       /* bytes of a list of names in a message */

/* One field of a line, [begin, end), without the blanks around it. */
struct csv_field {
  const char *begin, *end;
};

/* Names gathered for one message; what has no room becomes "...". Begins as {"", 0}. */
struct csv_list {
  char text[CSV_LIST];
  size_t used;
};
void csv_list_add(struct csv_list *list, const char *separator, const char *name);

struct csv_header {
  const char *path;
  const char *const *name; /* known columns, NULL for one that is not wanted; the caller's */
  size_t names;            /* <= CSV_MAX_COLUMNS */
  const char *advice; /* nullable: what a message about a fault that can be mended ends with; the caller's */

  size_t fields;                    /* of each line; 0 until the header line has been read */
  int8_t place[CSV_MAX_FIELDS];     /* of each field's number in a row, -1 where it is not read */
  size_t width;                     /* numbers in a row */
  size_t column[CSV_MAX_COLUMNS];   /* of each place: which name */
  double largest[CSV_MAX_COLUMNS];  /* size of a number there */
  int8_t place_of[CSV_MAX_COLUMNS]; /* of each name: its place, -1 where it is missing */
  struct csv_list unknown;          /* fields that are not read, for a note */
  struct csv_list found;            /* all fields, for a message */
  const char *separator;            /* words on a separator other than the comma, or "" */
};

/* How far a file has been read, line by line. */
struct csv_lines {
  struct csv_header *header;
  size_t line;       /* number of the line to come, from 1 on */
  size_t blank_line; /* of the first blank line behind the last row, or 0 */
};

/* ---- a line -------------------------------------------------------------------------------- */

enum { CSV_NOTHING = 0, CSV_ROW = 1, CSV_HEADER = 2 };

/* Takes the line [line, newline): CSV_HEADER, CSV_ROW with its numbers in row[width], CSV_NOTHING for a comment or a
 * blank line; -1 on failure. `cut`: the file's last line, without a newline. The caller counts lines->line. */
int csv_take(struct csv_lines *lines, const char *line, const char *newline, int cut, double *row,
             struct app_error *error);

/* The numbers of the line at `c` (a newline and TEXT_PAD bytes follow somewhere): where the next line begins, or NULL
 * when the line is not as simple as most are; then csv_take has the last word. */
const char *csv_plain_row(const struct csv_header *header, const char *c, double *row);

/* "missing column: ..." with what the header line holds instead; `why` follows the names. Nullable: why. */
int csv_missing(const struct csv_header *header, size_t line, const char *names, const char *why,
                struct app_error *error);
/* The advice, or "". */
const char *csv_advice(const struct csv_header *header);
/* Fails with the row before which a blank line stands. */
int csv_blank(const struct csv_lines *lines, struct app_error *error);
/* At the file's end: was there a header line? */
int csv_begun(const struct csv_lines *lines, struct app_error *error);
/* Fails with a line that is longer than any block of text. */
int csv_endless(const struct csv_lines *lines, struct app_error *error);

/* ---- a file -------------------------------------------------------------------------------- */

/* The text behind a byte order mark. */
const char *csv_skip_mark(const char *text, size_t length);

/* `header` sees the header line once it is read, `row` each row; anything but 0 ends the reading as a failure. */
struct csv_visitor {
  int (*header)(const struct csv_lines *lines, void *context, struct app_error *error);
  int (*row)(const struct csv_lines *lines, const double *row, void *context, struct app_error *error);
};
/* Reads a file from its beginning to its end: 0, or -1. An empty file, or one without a header line, fails. */
int csv_read(struct csv_header *header, const struct csv_visitor *visitor, void *context,
             struct app_error *error);

#endif
