/* account.c: sums and differences. */
#include "account.h"

static uint64_t apart(uint64_t a, uint64_t b) {
  return a > b ? a - b : b - a;
}

uint64_t account_difference(const struct account *a) {
  return apart(a->read, a->frames + a->errors + a->malformed + a->foreign) +
         apart(a->frames, a->written + a->not_written);
}

uint64_t account_lost(const struct account *a) {
  return a->lost[0] + a->lost[1] + a->malformed + a->not_written + (a->written - a->synced) +
         account_difference(a);
}
