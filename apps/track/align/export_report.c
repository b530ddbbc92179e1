/* export_report.c: zero_ns of the report, where it is on CLOCK_MONOTONIC. */
#include "track/align/export_report.h"

#include <string.h>

#include "common/json_file.h"

static int has_text(const json_t *root, const char *key, const char *text) {
  const char *found = json_string_value(json_object_get(root, key));
  return found && strcmp(found, text) == 0;
}

int export_report_offset(const char *path, double *offset_s, struct app_error *error) {
  json_t *root = json_load_file(path, 0, NULL);
  const json_t *zero = json_object_get(root, "zero_ns");
  const int is_report = has_text(root, "schema", "talus-export/1") && json_is_integer(zero);
  const int is_monotonic = is_report && has_text(root, "clock", "CLOCK_MONOTONIC");
  if (is_monotonic) *offset_s = -1e-9 * (double)json_integer_value(zero);
  json_decref(root);
  if (!is_report) return app_fail(error, APP_BAD_INPUT, "%s: is no report of talus-acquire-export", path);
  if (!is_monotonic)
    return app_fail(error, APP_BAD_INPUT,
                    "%s: its recording stands on the stamps' clock: nothing relates that to the camera's",
                    path);
  return 0;
}
