/* status.c: a text for each status. */
#include "talus/status.h"

const char *tl_status_text(tl_status status) {
  switch (status) {
  case TL_OK: return "success";
  case TL_ERR_ARGUMENT: return "invalid argument";
  case TL_ERR_RANGE: return "value out of range";
  case TL_ERR_TOO_SHORT: return "too few samples";
  case TL_ERR_NOT_FINITE: return "not a finite number";
  case TL_ERR_SINGULAR: return "the equations do not determine an answer";
  case TL_ERR_NO_CONVERGENCE: return "no convergence";
  case TL_ERR_WORKSPACE: return "workspace too small";
  case TL_ERR_UNSUPPORTED: return "not supported for this kind";
  }
  return "unknown status";
}
