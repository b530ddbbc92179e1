/* csv_header.c: the header line: which field is which column. */
#include <stdio.h>
#include <string.h>

#include "csv.h"
#include "csv_field.h"

void csv_list_add(struct csv_list *list, const char *separator, const char *name) {
  static const char more[] = ", ...";
  const size_t room = sizeof list->text - sizeof more - list->used;
  char *end = list->text + list->used;
  if (list->used >= sizeof more - 1 && strcmp(end - (sizeof more - 1), more) == 0) return;
  const int n = snprintf(end, room, "%s%s", list->used ? separator : "", name);
  if (n >= 0 && (size_t)n < room)
    list->used += (size_t)n;
  else {
    memcpy(end, more, sizeof more);
    list->used += sizeof more - 1;
  }
}

static void add_field(struct csv_list *list, struct csv_field name, size_t number) {
  char text[80];
  if (name.begin == name.end)
    snprintf(text, sizeof text, "(column %zu, without a name)", number);
  else
    app_printable(text, sizeof text, name.begin, (size_t)(name.end - name.begin));
  csv_list_add(list, ", ", text);
}

/* which known name this is, or -1 */
static int find_name(const struct csv_header *h, struct csv_field name) {
  const size_t length = (size_t)(name.end - name.begin);
  for (size_t k = 0; k < h->names; k++)
    if (h->name[k] && strlen(h->name[k]) == length && memcmp(h->name[k], name.begin, length) == 0)
      return (int)k;
  return -1;
}

/* beyond this a number is no time [s], angle, current or torque; products of such numbers overflow */
static double largest(const char *name) {
  return strcmp(name, "time_s") == 0 ? 1e12 : 1e9;
}

static int add_column(struct csv_header *h, struct csv_field field, size_t line, struct app_error *error) {
  if (h->fields == CSV_MAX_FIELDS)
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: more than %d columns", h->path, line, CSV_MAX_FIELDS);
  const int name = find_name(h, field);
  h->place[h->fields++] = -1;
  add_field(&h->found, field, h->fields);
  if (name < 0) {
    add_field(&h->unknown, field, h->fields);
    return 0;
  }
  if (h->place_of[name] >= 0)
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: column %s stands twice in the header", h->path, line,
                    h->name[name]);
  h->place[h->fields - 1] = h->place_of[name] = (int8_t)h->width;
  h->largest[h->width] = largest(h->name[name]);
  h->column[h->width++] = (size_t)name;
  return 0;
}

const char *csv_advice(const struct csv_header *h) {
  return h->advice ? h->advice : "";
}

static int refuse_binary(const struct csv_header *h, const char *c, const char *end, size_t line,
                         struct app_error *error) {
  for (; c < end; c++)
    if ((unsigned char)*c < 0x20 && *c != '\t')
      return app_fail(error, APP_BAD_INPUT, "%s:%zu: not text: byte 0x%02x in the header line%s", h->path,
                      line, (unsigned)(unsigned char)*c, csv_advice(h));
  return 0;
}

/* does this separator lay a known name open, or part the line at all where none needs to be known? Then `found`
 * becomes the names it parts. */
static int parts_names(struct csv_header *h, char separator, int any, const char *c, const char *end) {
  struct csv_list found = {"", 0};
  int known = any && memchr(c, separator, (size_t)(end - c));
  for (size_t number = 1;; number++, c++) {
    const struct csv_field field = csv_field(c, end, separator, &c);
    known += find_name(h, field) >= 0;
    if (field.begin < field.end || separator != ' ') add_field(&found, field, number);
    if (c == end) break;
  }
  if (known) h->found = found;
  return known > 0;
}

/* A line without any known name may be parted by something else, and its message had better say so. */
static void find_separator(struct csv_header *h, const char *c, const char *end) {
  static const struct {
    char separator;
    const char *words;
  } other[] = {{';', " separated by ';', expected ','"},
               {'\t', " separated by tabs, expected ','"},
               {'|', " separated by '|', expected ','"},
               {' ', " separated by blanks, expected ','"}};
  const size_t count = sizeof other / sizeof other[0];
  if (h->width) return;
  /* first those that lay a name open; then, in a line that no comma parts, any but the blank, which names hold too */
  for (size_t k = 0; k < 2 * count - 1; k++)
    if ((k < count || h->fields == 1) && parts_names(h, other[k % count].separator, k >= count, c, end)) {
      h->separator = other[k % count].words;
      return;
    }
}

int csv_header_line(struct csv_header *h, const char *c, const char *end, size_t line,
                    struct app_error *error) {
  const char *at = c;
  h->fields = h->width = 0;
  h->separator = "";
  h->unknown = h->found = (struct csv_list){"", 0};
  memset(h->place_of, -1, sizeof h->place_of);
  if (refuse_binary(h, c, end, line, error) != 0) return -1;
  for (;; at++) {
    const struct csv_field field = csv_field(at, end, ',', &at);
    if (add_column(h, field, line, error) != 0) return -1;
    if (at == end) break;
  }
  find_separator(h, c, end);
  return 0;
}

int csv_missing(const struct csv_header *h, size_t line, const char *names, const char *why,
                struct app_error *error) {
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: missing column: %s%s; found %s%s%s", h->path, line, names,
                  why ? why : "", h->found.text, h->separator, csv_advice(h));
}
