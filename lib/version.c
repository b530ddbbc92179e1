/* version.c: the version that this library was built from. */
#include "talus/version.h"

const char *tl_version(void) {
  return TL_VERSION;
}
