/* json_file.h: JSON as the programs write it: keys in the order they were set, reals that read
 * back exactly, no NaN; so the same content is the same bytes.
 *
 *     json_t *report = json_object();
 *     json_set_number(report, "cost", cost);
 *     if (json_file_write(path, report, &error) != 0) ...
 *     json_decref(report);
 */
#ifndef JSON_FILE_H
#define JSON_FILE_H

#include <jansson.h>

#include "error.h"
#include "output.h"

/* A real, or null where x is not finite; a string, foreign bytes as '?'; n numbers as a list. */
json_t *json_number(double x);
json_t *json_text(const char *text);
json_t *json_numbers(const double *x, size_t n);
/* object[key] = x. */
void json_set_number(json_t *object, const char *key, double x);
void json_set_text(json_t *object, const char *key, const char *text);

/* Writes atomically (output.h), indented by one space. 0, or -1. The root stays the caller's. */
int json_file_write(const char *path, const json_t *root, struct app_error *error);

/* Writes compactly, fit for a script element of an HTML page: no '<' appears. `digits` of each real. */
void json_write_embedded(struct output *out, const json_t *root, size_t digits);

#endif
