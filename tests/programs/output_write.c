/* output_write.c: writes a file in one of the ways of output.h, for tests/test_output.py.
 *
 *   output_write rows PATH N       N rows of time and two values
 *   output_write abandon PATH N    the same, thrown away
 *   output_write json PATH         a JSON document
 *   output_write numbers PATH      each number of standard input (as bits) in both notations
 *   output_write envelope PATH N   the points of an envelope over N samples
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/json_file.h"
#include "common/output.h"
#include "page/envelope.h"

static void put_rows(struct output *out, size_t n) {
  output_text(out, "time_s,a,b\n");
  for (size_t i = 0; i < n; i++) {
    const double t = 0.001 * (double)i, value[2] = {sin(t), -1e-7 / (1.0 + t)};
    output_row(out, t, value, 2);
  }
}

static void put_numbers(struct output *out) {
  char line[64];
  while (fgets(line, sizeof line, stdin)) {
    const uint64_t bits = strtoull(line, NULL, 16);
    double x;
    memcpy(&x, &bits, sizeof x);
    output_exact(out, x);
    output_text(out, " ");
    output_number(out, x);
    output_text(out, "\n");
  }
}

static void put_envelope(struct output *out, size_t n) {
  static struct envelope e;
  static double t[ENVELOPE_POINTS], y[ENVELOPE_POINTS];
  envelope_init(&e);
  for (size_t i = 0; i < n; i++) {
    const double x = (double)(i * 2654435761u % 1000003u) / 1000003.0; /* any order of values */
    envelope_add(&e, (double)i, i % 1000 > 900 ? (double)NAN : x);
  }
  const size_t points = envelope_points(&e, t, y);
  for (size_t i = 0; i < points; i++) output_row(out, t[i], &y[i], 1);
}

static int write_json(const char *path, struct app_error *error) {
  const double list[3] = {0.1, (double)NAN, 1e300};
  json_t *root = json_object();
  json_set_number(root, "z", 1.0 / 3.0);
  json_set_number(root, "a", (double)INFINITY);
  json_set_text(root, "text", "caf\xc3\xa9 </script>");
  json_set_text(root, "foreign",
                "a\xff"
                "b");
  json_object_set_new(root, "list", json_numbers(list, 3));
  const int result = json_file_write(path, root, error);
  json_decref(root);
  return result;
}

int main(int argc, char **argv) {
  struct app_error error;
  app_set_name("output_write");
  if (argc < 3) return APP_BAD_INPUT;
  if (strcmp(argv[1], "json") == 0) return write_json(argv[2], &error) == 0 ? APP_OK : app_exit(&error);
  struct output *out = output_open(argv[2], &error);
  if (!out) return app_exit(&error);
  const size_t n = argc > 3 ? (size_t)strtoul(argv[3], NULL, 10) : 0;
  if (strcmp(argv[1], "numbers") == 0)
    put_numbers(out);
  else if (strcmp(argv[1], "envelope") == 0)
    put_envelope(out, n);
  else
    put_rows(out, n);
  if (strcmp(argv[1], "abandon") == 0) {
    output_abandon(out);
    return APP_OK;
  }
  return output_commit(out, &error) == 0 ? APP_OK : app_exit(&error);
}
