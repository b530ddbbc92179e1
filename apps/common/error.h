/* error.h: one clear line about what went wrong, and the exit status for it.
 *
 * A function that can fail returns 0, or -1 with the caller's app_error filled:
 *
 *     struct app_error error;
 *     if (model_file_read(path, &model, &error) != 0) return app_exit(&error);
 *
 * The text says where (file and line, or column), what, and what was expected;
 * it is always a single line of printable UTF-8, whatever bytes a bad file held.
 */
#ifndef APP_ERROR_H
#define APP_ERROR_H

#include <stddef.h>

#if defined(__GNUC__) && !defined(TL_NO_ATTRIBUTES)
#define APP_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define APP_PRINTF(text, first)
#endif

/* exit statuses */
enum {
  APP_OK = 0,
  APP_FAILED = 1,   /* out of memory, disk full, cannot write, no convergence ... */
  APP_BAD_INPUT = 2 /* bad usage, a bad recording or a bad model */
};

struct app_error {
  int status;
  char text[1024]; /* cut with "..." where it would be longer */
};

/* The name that messages begin with, such as "talus-identify"; kept, not copied. */
void app_set_name(const char *name);
const char *app_name(void);

/* Fills `e` and returns -1. */
int app_fail(struct app_error *e, int status, const char *format, ...) APP_PRINTF(3, 4);

/* Prints "NAME: text" to standard error and returns the exit status. */
int app_exit(const struct app_error *e);

/* Prints "NAME: note: ..." to standard error: something a user should know, no failure. */
void app_note(const char *format, ...) APP_PRINTF(1, 2);
/* 0: nothing is noted from now on, for a caller that speaks for itself. */
void app_tell_notes(int told);

/* Copies n bytes of foreign text, a piece of a message, into out[size]: what is no printable
 * UTF-8 becomes '?', and what does not fit is cut with "...". Returns `out`. */
const char *app_printable(char *out, size_t size, const char *text, size_t n);

#endif
