/* error.c: messages for people, on standard error. */
#include "error.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const char *program_name = "talus";
static int notes_told = 1;

void app_set_name(const char *name) {
  program_name = name;
}

const char *app_name(void) {
  return program_name;
}

/* bytes of the UTF-8 character at c, or 0 where there is none (control characters included) */
static size_t character(const unsigned char *c) {
  static const unsigned least[] = {0, 0, 0x80, 0x800, 0x10000};
  const size_t n = c[0] < 0x80   ? 1
                   : c[0] < 0xc0 ? 0
                   : c[0] < 0xe0 ? 2
                   : c[0] < 0xf0 ? 3
                   : c[0] < 0xf8 ? 4
                                 : 0;
  if (n <= 1) return n == 1 && c[0] >= 0x20 && c[0] != 0x7f;
  unsigned code = c[0] & (0xffu >> (n + 1));
  for (size_t i = 1; i < n; i++) {
    if ((c[i] & 0xc0) != 0x80) return 0;
    code = code << 6 | (c[i] & 0x3fu);
  }
  return code >= least[n] && code <= 0x10ffff && (code & 0x1ff800) != 0xd800 ? n : 0;
}

/* one line of text that every terminal can show, whatever the bytes were */
static void tidy(char *text) {
  for (unsigned char *c = (unsigned char *)text; *c;) {
    const size_t n = character(c);
    if (n == 0) *c = '?';
    c += n ? n : 1;
  }
}

/* the same for a text that would have been `length` bytes long in a buffer of `size` */
static void finish(char *text, size_t size, int length) {
  if (length < 0) text[0] = '\0';
  if (length >= (int)size) memcpy(text + size - 4, "...", 4);
  tidy(text);
}

int app_fail(struct app_error *e, int status, const char *format, ...) {
  va_list arguments;
  e->status = status;
  va_start(arguments, format);
  const int length = vsnprintf(e->text, sizeof e->text, format, arguments);
  va_end(arguments);
  finish(e->text, sizeof e->text, length);
  return -1;
}

int app_exit(const struct app_error *e) {
  fprintf(stderr, "%s: %s\n", program_name, e->text);
  return e->status;
}

void app_tell_notes(int told) {
  notes_told = told;
}

void app_note(const char *format, ...) {
  char text[1024];
  va_list arguments;

  if (!notes_told) return;
  va_start(arguments, format);
  const int length = vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  finish(text, sizeof text, length);
  fprintf(stderr, "%s: note: %s\n", program_name, text);
}

const char *app_printable(char *out, size_t size, const char *text, size_t n) {
  const size_t kept = n < size ? n : size - 1;
  for (size_t i = 0; i < kept; i++) out[i] = text[i] ? text[i] : '?';
  out[kept] = '\0';
  if (kept < n && size > 4) memcpy(out + size - 4, "...", 4);
  tidy(out);
  return out;
}
