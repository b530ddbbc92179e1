/* yaml_map.h: a YAML file against a table of what may stand in it.
 *
 *     static const struct yaml_entry point[] = {
 *         {.key = "x_m", .required = 1, .read = yaml_read_number, .offset = offsetof(struct point, x_m)},
 *         {.key = "y_m", .required = 1, .read = yaml_read_number, .offset = offsetof(struct point, y_m)}};
 *     struct yaml_file file;
 *     if (yaml_file_open(&file, path, &error) != 0) ...
 *     int result = yaml_read_map(&file, yaml_file_root(&file), point, 2, &p, &error);
 *     yaml_file_close(&file);
 *
 * Whatever is wrong ends with a text "FILE:LINE: dotted.key: what, expected what":
 * a key that is unknown, missing or double, a value of another type or out of its range.
 */
#ifndef YAML_MAP_H
#define YAML_MAP_H

#include <stddef.h>
#include <yaml.h>

#include "common/error.h"

struct yaml_file {
  const char *path; /* must outlive it */
  yaml_document_t document;
  char key[256]; /* dotted key of the node that is being read, for messages */
};

enum yaml_range {
  YAML_ANY = 0, /* finite */
  YAML_POSITIVE,
  YAML_NOT_NEGATIVE,
  YAML_NOT_ZERO
};

/* A key that a mapping may have, and how its value is read into `target` + offset. */
struct yaml_entry {
  const char *key;
  int required;
  int (*read)(struct yaml_file *file, yaml_node_t *node, const struct yaml_entry *entry, void *target,
              struct app_error *error);
  size_t offset;
  enum yaml_range range;        /* numbers */
  int low, high;                /* whole numbers */
  size_t length;                /* lists of numbers */
  const struct yaml_entry *map; /* mappings: their entries, `entries` of them, at the same target */
  size_t entries;
};

/* Parses the file, which must hold one document that is a mapping. Nothing is open on failure. */
int yaml_file_open(struct yaml_file *file, const char *path, struct app_error *error);
void yaml_file_close(struct yaml_file *file);
yaml_node_t *yaml_file_root(struct yaml_file *file);

/* All of a mapping's keys by a table. */
int yaml_read_map(struct yaml_file *file, yaml_node_t *map, const struct yaml_entry *entry, size_t entries,
                  void *target, struct app_error *error);
/* The value of a key, or NULL; `map` may be anything. */
yaml_node_t *yaml_find(struct yaml_file *file, const yaml_node_t *map, const char *key);

/* For yaml_entry.read: a double, an int within low..high, `length` doubles, a mapping, and
 * a mapping's node itself (yaml_node_t *), to be read later. */
int yaml_read_number(struct yaml_file *file, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                     struct app_error *error);
int yaml_read_whole(struct yaml_file *file, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                    struct app_error *error);
int yaml_read_numbers(struct yaml_file *file, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                      struct app_error *error);
int yaml_read_section(struct yaml_file *file, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                      struct app_error *error);
int yaml_read_later(struct yaml_file *file, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                    struct app_error *error);

/* For yaml_entry.read: a scalar's text (const char *), good while the file is open. */
int yaml_read_name(struct yaml_file *file, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                   struct app_error *error);

/* What a number in `range` must be, in words, when x is none; NULL when it is. */
const char *yaml_range_fault(enum yaml_range range, double x);

/* The text of a scalar that is to be a name; NULL, with the error filled, for any other node. */
const char *yaml_text(struct yaml_file *file, const yaml_node_t *node, struct app_error *error);

/* Adds ".key" to the dotted key; the answer goes to yaml_key_leave afterwards. */
size_t yaml_key_enter(struct yaml_file *file, const char *key);
void yaml_key_leave(struct yaml_file *file, size_t before);

/* "FILE:LINE: dotted.key: ..." with status 2; returns -1. */
int yaml_fail(const struct yaml_file *file, const yaml_node_t *node, struct app_error *error,
              const char *format, ...) APP_PRINTF(4, 5);

#endif
