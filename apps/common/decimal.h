/* decimal.h: decimal text to double, fast and exactly rounded, whatever the locale.
 *
 *     double x;
 *     const char *end;
 *     if (decimal_parse("-1.25e-3,", &x, &end) == DECIMAL_OK) ... *end == ','
 *
 * The grammar is [+-] digits [. digits] [(e|E) [+-] digits], with digits on at
 * least one side of the point. Results are the nearest double, ties to even.
 */
#ifndef DECIMAL_H
#define DECIMAL_H

enum decimal_status {
  DECIMAL_OK = 0,
  DECIMAL_NOT_A_NUMBER = 1,
  DECIMAL_NOT_FINITE = 2 /* nan, inf, infinity, or too large for a double */
};

/* Reads the number at `text`, which ends at the first byte that cannot belong to
 * it; so the text needs no zero byte, only some byte after the number, such as a
 * comma or a newline. *end is that byte. On failure *x is untouched. */
enum decimal_status decimal_parse(const char *text, double *x, const char **end);

/* The same, faster, where at least DECIMAL_PAD bytes after the number's first can be read. */
#define DECIMAL_PAD 40
enum decimal_status decimal_parse_padded(const char *text, double *x, const char **end);

#endif
