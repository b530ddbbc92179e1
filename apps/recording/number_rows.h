/* number_rows.h: a table of doubles as lines of text with a fixed number of decimals, byte for byte what "%.*f" makes of each, but fast.
 *
 *     double row[] = {0.1, -2.5};
 *     int places[] = {1, 3};
 *     char text[NUMBER_ROWS_TEXT(2)];
 *     number_rows(text, row, 1, 2, places);       "0.1,-2.500\n"
 */
#ifndef NUMBER_ROWS_H
#define NUMBER_ROWS_H

#include <stddef.h>

#define NUMBER_ROWS_TEXT(numbers) (32 * (numbers)) /* bytes that so many may take */
#define NUMBER_ROWS_PLACES 12

/* `places` of each column, up to NUMBER_ROWS_PLACES. Answers the bytes written; -1 where a number is not finite, or from 2^52 on in units of
 * its last place: then nothing in `text` counts. */
long number_rows(char *text, const double *x, size_t rows, int columns, const int *places);

#endif
