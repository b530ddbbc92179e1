/* text.h: lines put together in memory that is there already, without stdio. */
#ifndef TEXT_H
#define TEXT_H

#include <stddef.h>
#include <stdint.h>

struct text {
  char *at;
  size_t used, size;
};

/* What does not fit is left out whole, so ask text_room first. */
size_t text_room(const struct text *t);
void text_put(struct text *t, const char *bytes, size_t n);
void text_string(struct text *t, const char *s);
void text_whole(struct text *t, int64_t value);

/* JSON: {"type":"drop", then ,"key":value, then }newline. Names and texts hold no quotes. */
void text_begin(struct text *t, const char *type);
void text_key(struct text *t, const char *key);
void text_set(struct text *t, const char *key, int64_t value);
void text_set_bool(struct text *t, const char *key, int value);
void text_set_string(struct text *t, const char *key, const char *value);
void text_end(struct text *t);

#endif
