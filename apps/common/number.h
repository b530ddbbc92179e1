/* number.h: doubles as decimal text, with '.' whatever the locale.
 *
 *     char text[NUMBER_TEXT];
 *     number_exact(text, 0.1);      "0.1": the fewest digits that read back as the same double
 *     number_rounded(text, 1.0/3);  "0.333333333333": 12 significant digits, fast
 *
 * Both answer the length. Not finite numbers become "nan", "inf", "-inf".
 */
#ifndef NUMBER_H
#define NUMBER_H

#include <stddef.h>

#define NUMBER_TEXT 32

/* 12, 15, 16 or 17 significant digits, whichever is the first to read back exactly. */
size_t number_exact(char text[NUMBER_TEXT], double x);
/* At most 12 significant digits, zeros at the end left off. The last digit may be the other
 * neighbour's where x lies within 1e-16 of the middle of two. */
size_t number_rounded(char text[NUMBER_TEXT], double x);

#endif
