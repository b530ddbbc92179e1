/* status.h: what a call of the library can answer.
 *
 * Every function that can fail returns a tl_status: zero is success, failures
 * are negative and keep their number for ever. Outputs are untouched on
 * failure unless a function says otherwise. The library never prints.
 *
 *     tl_status status = TL_ERR_RANGE;
 *     if (status != TL_OK) puts(tl_status_text(status)); // prints value out of range
 */
#ifndef TALUS_STATUS_H
#define TALUS_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__) && !defined(TL_NO_ATTRIBUTES)
#define TL_CHECK __attribute__((warn_unused_result))
#else
#define TL_CHECK
#endif

typedef enum tl_status {
  TL_OK = 0,
  TL_ERR_ARGUMENT = -1,       /* null pointer, impossible size, unknown kind */
  TL_ERR_RANGE = -2,          /* a value outside its physical or documented range */
  TL_ERR_TOO_SHORT = -3,      /* too few samples for what was asked */
  TL_ERR_NOT_FINITE = -4,     /* NaN or infinity where a number was expected */
  TL_ERR_SINGULAR = -5,       /* the equations do not determine an answer */
  TL_ERR_NO_CONVERGENCE = -6, /* an iteration ended without its tolerance */
  TL_ERR_WORKSPACE = -7,      /* the caller's memory is too small */
  TL_ERR_UNSUPPORTED = -8     /* legal, but not for this plant or kind */
} tl_status;

/* A short English text for `status`, never NULL; "unknown status" for a
 * number that is none of the enumeration's. */
const char *tl_status_text(tl_status status);

#ifdef __cplusplus
}
#endif
#endif
