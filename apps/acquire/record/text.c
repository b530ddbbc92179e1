/* text.c: JSON lines by hand. */
#include "text.h"

#include <string.h>

enum { DIGITS = 20 };

size_t text_room(const struct text *t) {
  return t->size - t->used;
}

void text_put(struct text *t, const char *bytes, size_t n) {
  if (n > text_room(t)) return;
  memcpy(t->at + t->used, bytes, n);
  t->used += n;
}

void text_string(struct text *t, const char *s) {
  text_put(t, s, strlen(s));
}

void text_whole(struct text *t, int64_t value) {
  char digit[DIGITS];
  uint64_t rest = value < 0 ? 0 - (uint64_t)value : (uint64_t)value;
  int i = DIGITS;
  do digit[--i] = (char)('0' + rest % 10);
  while (rest /= 10);
  if (value < 0) text_put(t, "-", 1);
  text_put(t, digit + i, (size_t)(DIGITS - i));
}

void text_begin(struct text *t, const char *type) {
  text_string(t, "{\"type\":\"");
  text_string(t, type);
  text_string(t, "\"");
}

void text_key(struct text *t, const char *key) {
  text_string(t, ",\"");
  text_string(t, key);
  text_string(t, "\":");
}

void text_set(struct text *t, const char *key, int64_t value) {
  text_key(t, key);
  text_whole(t, value);
}

void text_set_bool(struct text *t, const char *key, int value) {
  text_key(t, key);
  text_string(t, value ? "true" : "false");
}

/* control characters, quotes and backslashes become '?' */
void text_set_string(struct text *t, const char *key, const char *value) {
  text_key(t, key);
  text_put(t, "\"", 1);
  for (; *value; value++) {
    const unsigned char c = (unsigned char)*value;
    text_put(t, c < ' ' || c == '"' || c == '\\' ? "?" : value, 1);
  }
  text_put(t, "\"", 1);
}

void text_end(struct text *t) {
  text_put(t, "}\n", 2);
}
