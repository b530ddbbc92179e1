/* error.c: messages for people, on standard error. */
#include "error.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const char *program_name = "talus";

void app_set_name(const char *name) {
  program_name = name;
}

const char *app_name(void) {
  return program_name;
}

static int is_control(char c) {
  const unsigned char byte = (unsigned char)c;
  return byte < 0x20 || byte == 0x7f;
}

/* one line, whatever the pieces held; `length` is what vsnprintf wanted to write */
static void tidy(char *text, size_t size, int length) {
  if (length < 0) text[0] = '\0';
  if (length >= (int)size) memcpy(text + size - 4, "...", 4);
  for (char *c = text; *c; c++)
    if (is_control(*c)) *c = '?';
}

int app_fail(struct app_error *e, int status, const char *format, ...) {
  va_list arguments;
  e->status = status;
  va_start(arguments, format);
  const int length = vsnprintf(e->text, sizeof e->text, format, arguments);
  va_end(arguments);
  tidy(e->text, sizeof e->text, length);
  return -1;
}

int app_exit(const struct app_error *e) {
  fprintf(stderr, "%s: %s\n", program_name, e->text);
  return e->status;
}

void app_note(const char *format, ...) {
  char text[1024];
  va_list arguments;
  va_start(arguments, format);
  const int length = vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  tidy(text, sizeof text, length);
  fprintf(stderr, "%s: note: %s\n", program_name, text);
}

const char *app_printable(char *out, size_t size, const char *text, size_t n) {
  const size_t kept = n < size ? n : size - 1;
  for (size_t i = 0; i < kept; i++) out[i] = is_control(text[i]) ? '?' : text[i];
  out[kept] = '\0';
  if (kept < n && size > 4) memcpy(out + size - 4, "...", 4);
  return out;
}
