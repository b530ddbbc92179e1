/* recording_header.c: the header line of a recording. */
#include <stdio.h>
#include <string.h>

#include "model/plant_name.h"
#include "recording_layout.h"

/* Names that are gathered for one message. */
struct name_list {
  char text[600];
  size_t used;
};

static void list_add(struct name_list *list, const char *separator, const char *name) {
  const size_t room = sizeof list->text - list->used;
  const int n = snprintf(list->text + list->used, room, "%s%s", list->used ? separator : "", name);
  if (n >= 0) list->used += (size_t)n < room ? (size_t)n : room - 1;
}

static void list_add_field(struct name_list *list, struct field name, size_t number) {
  char text[80];
  if (name.begin == name.end)
    snprintf(text, sizeof text, "(column %zu, without a name)", number);
  else
    app_printable(text, sizeof text, name.begin, (size_t)(name.end - name.begin));
  list_add(list, ", ", text);
}

static void list_add_set(struct name_list *list, uint32_t set) {
  for (int c = 0; c < TL_CHANNEL_COUNT; c++)
    if (set & TL_CHANNEL_BIT(c)) list_add(list, " or ", tl_channel_name((tl_channel)c));
}

static int is_blank(char c) {
  return c == ' ' || c == '\t';
}

struct field layout_field(const char *c, const char *line_end, const char **next) {
  const char *comma = memchr(c, ',', (size_t)(line_end - c));
  struct field field = {c, comma ? comma : line_end};
  *next = field.end;
  while (field.begin < field.end && is_blank(*field.begin)) field.begin++;
  while (field.end > field.begin && is_blank(field.end[-1])) field.end--;
  return field;
}

/* the channel among `known` whose name this is, or -1 */
static int find_channel(struct field name, uint32_t known) {
  const size_t length = (size_t)(name.end - name.begin);
  for (int c = 0; c < TL_CHANNEL_COUNT; c++) {
    const char *candidate = tl_channel_name((tl_channel)c);
    if ((known & TL_CHANNEL_BIT(c)) && strlen(candidate) == length &&
        memcmp(candidate, name.begin, length) == 0)
      return c;
  }
  return -1;
}

/* one name more: its place, or a name of the unknown */
static int add_column(struct layout *layout, struct field name, uint32_t known, size_t line,
                      struct name_list *unknown, struct app_error *error) {
  if (layout->fields == LAYOUT_MAX_FIELDS)
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: more than %d columns", layout->path, line,
                    LAYOUT_MAX_FIELDS);
  const int channel = find_channel(name, known);
  layout->slot[layout->fields++] = -1;
  if (channel < 0) {
    list_add_field(unknown, name, layout->fields);
    return 0;
  }
  if (layout->slot_of[channel] >= 0)
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: column %s stands twice in the header", layout->path, line,
                    tl_channel_name((tl_channel)channel));
  layout->slot[layout->fields - 1] = layout->slot_of[channel] = (int8_t)layout->width;
  layout->channel[layout->width++] = (tl_channel)channel;
  return 0;
}

static int check_complete(const struct layout *layout, const tl_channel_set *set, size_t line,
                          struct app_error *error) {
  uint32_t there = 0;
  for (size_t i = 0; i < layout->width; i++) there |= TL_CHANNEL_BIT(layout->channel[i]);
  struct name_list missing = {"", 0};
  for (int c = 0; c < TL_CHANNEL_COUNT; c++)
    if (set->required & ~there & TL_CHANNEL_BIT(c)) list_add(&missing, ", ", tl_channel_name((tl_channel)c));
  for (int i = 0; i < 2; i++)
    if (set->any_of[i] && !(set->any_of[i] & there)) {
      struct name_list choice = {"", 0};
      list_add_set(&choice, set->any_of[i]);
      list_add(&missing, ", ", choice.text);
    }
  if (!missing.used) return 0;
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: missing column: %s (a %s's recording needs it)",
                  layout->path, line, missing.text, plant_name(layout->plant));
}

static int refuse_binary(const struct layout *layout, const char *c, const char *end, size_t line,
                         struct app_error *error) {
  for (; c < end; c++)
    if ((unsigned char)*c < 0x20 && *c != '\t')
      return app_fail(error, APP_BAD_INPUT, "%s:%zu: not text: byte 0x%02x in the header line", layout->path,
                      line, (unsigned)*c);
  return 0;
}

int layout_read(struct layout *layout, const char *path, tl_plant plant, const char *c, const char *end,
                size_t line, struct app_error *error) {
  tl_channel_set set;
  layout->path = path;
  layout->plant = plant;
  layout->fields = layout->width = 0;
  memset(layout->slot_of, -1, sizeof layout->slot_of);
  if (tl_channel_set_of(plant, &set) != TL_OK) return app_fail(error, APP_FAILED, "unknown plant");
  if (refuse_binary(layout, c, end, line, error) != 0) return -1;
  struct name_list unknown = {"", 0};
  for (;;) {
    const struct field name = layout_field(c, end, &c);
    if (add_column(layout, name, set.known, line, &unknown, error) != 0) return -1;
    if (c == end) break;
    c++;
  }
  if (check_complete(layout, &set, line, error) != 0) return -1;
  memcpy(layout->unknown, unknown.text, sizeof layout->unknown);
  return 0;
}
