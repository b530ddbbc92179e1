/* decimal_bits.c: each line of standard input as a double's bits, for tests/test_recording_reader.py.
 * Prints 16 hexadecimal digits, or "nan" (no number), "inf" (not finite), "rest" (bytes left over). */
#include <inttypes.h>
#include <locale.h>
#include <stdio.h>
#include <string.h>

#include "common/decimal.h"

int main(void) {
  char line[4096];
  /* whatever locale the environment asks for */
  setlocale(LC_ALL, "");
  while (fgets(line, sizeof line, stdin)) {
    double x = 0.0;
    const char *end;
    uint64_t bits;
    const enum decimal_status status = decimal_parse(line, &x, &end);
    memcpy(&bits, &x, sizeof bits);
    if (status == DECIMAL_NOT_A_NUMBER)
      puts("nan");
    else if (status == DECIMAL_NOT_FINITE)
      puts("inf");
    else if (*end != '\n')
      puts("rest");
    else
      printf("%016" PRIx64 "\n", bits);
  }
  return 0;
}
