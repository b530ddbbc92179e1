/* output.h: a file that appears whole or not at all.
 *
 *     struct output *out = output_open(path, &error);
 *     output_text(out, "time_s,slider_force_N\n");
 *     output_row(out, t_s, &force_N, 1);
 *     if (output_commit(out, &error) != 0) return app_exit(&error);
 *
 * What is written goes to a temporary file in the same folder; committing syncs it
 * and renames it to its name. Until then, and after any failure (disk full, a
 * folder that may not be written), an earlier file of that name is what it was,
 * and nothing of the new one stays. Failures of writing are kept until the
 * commit, so callers need not look at each call. A device or a pipe, such
 * as /dev/stdout, is written as it is.
 */
#ifndef OUTPUT_H
#define OUTPUT_H

#include <stddef.h>

#include "error.h"

struct output;

/* NULL with status 1 on failure. A path of NULL or "-" is standard output. The path must
 * outlive the output. Ends with output_commit or output_abandon, which free it. */
struct output *output_open(const char *path, struct app_error *error);

/* Could a file of this name be written? 0, or -1 with status 1; nothing is changed. For a program that
 * writes several files, or computes long, and would rather know before. */
int output_probe(const char *path, struct app_error *error);
/* Do two paths lead to one file? Not when that is a device or a pipe. */
int output_same(const char *path, const char *other);

void output_bytes(struct output *out, const void *bytes, size_t n);
void output_text(struct output *out, const char *text);
void output_printf(struct output *out, const char *format, ...) APP_PRINTF(2, 3);
/* A number with 12 significant digits (number_rounded), and one that reads back exactly. */
void output_number(struct output *out, double x);
void output_exact(struct output *out, double x);
/* One line of a CSV file: the time, exactly, and n values with 12 significant digits. */
void output_row(struct output *out, double t_s, const double *value, size_t n);

/* 0, or -1 with status 1 and what went wrong first. */
int output_commit(struct output *out, struct app_error *error);
/* Throws away what was written. Nullable: out. */
void output_abandon(struct output *out);

#endif
