/* json_file.c: JSON out. */
#include "json_file.h"

#include <math.h>
#include <string.h>

json_t *json_number(double x) {
  return isfinite(x) ? json_real(x) : json_null();
}

void json_set_number(json_t *object, const char *key, double x) {
  json_object_set_new(object, key, json_number(x));
}

/* text that is no UTF-8, such as an odd file name */
static json_t *foreign_string(const char *text) {
  char printable[1024];
  return json_string(app_printable(printable, sizeof printable, text, strlen(text)));
}

json_t *json_text(const char *text) {
  json_t *string = json_string(text);
  return string ? string : foreign_string(text);
}

void json_set_text(json_t *object, const char *key, const char *text) {
  json_object_set_new(object, key, json_text(text));
}

json_t *json_numbers(const double *x, size_t n) {
  json_t *list = json_array();
  for (size_t i = 0; i < n; i++) json_array_append_new(list, json_number(x[i]));
  return list;
}

static int write_plain(const char *text, size_t n, void *out) {
  output_bytes(out, text, n);
  return 0;
}

int json_file_write(const char *path, const json_t *root, struct app_error *error) {
  struct output *out = output_open(path, error);
  if (!out) return -1;
  if (json_dump_callback(root, write_plain, out, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) != 0) {
    output_abandon(out);
    return app_fail(error, APP_FAILED, "%s: out of memory", path ? path : "standard output");
  }
  output_text(out, "\n");
  return output_commit(out, error);
}

/* '<' stands only within strings, where it has an escape: nothing can end the script element */
static int write_escaped(const char *text, size_t n, void *out) {
  const char *end = text + n;
  while (text < end) {
    const char *next = memchr(text, '<', (size_t)(end - text));
    output_bytes(out, text, (size_t)((next ? next : end) - text));
    if (!next) break;
    output_text(out, "\\u003c");
    text = next + 1;
  }
  return 0;
}

void json_write_embedded(struct output *out, const json_t *root, size_t digits) {
  json_dump_callback(root, write_escaped, out, JSON_COMPACT | JSON_REAL_PRECISION(digits));
}
