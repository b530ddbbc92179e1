/* yaml_map.c: tables against the nodes of a YAML document. */
#include "yaml_map.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/decimal.h"
#include "common/text_file.h"

/* ---- messages -------------------------------------------------------------- */

int yaml_fail(const struct yaml_file *file, const yaml_node_t *node, struct app_error *error,
              const char *format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: %s%s%s", file->path, node->start_mark.line + 1, file->key,
                  file->key[0] ? ": " : "", text);
}

size_t yaml_key_enter(struct yaml_file *file, const char *key) {
  const size_t before = strlen(file->key);
  snprintf(file->key + before, sizeof file->key - before, "%s%s", before ? "." : "", key);
  return before;
}

void yaml_key_leave(struct yaml_file *file, size_t before) {
  file->key[before] = '\0';
}

static const char *scalar(const yaml_node_t *node) {
  return (const char *)node->data.scalar.value;
}

/* what a node is, in words */
static const char *describe(const yaml_node_t *node, char out[64]) {
  char quoted[40];
  if (node->type == YAML_MAPPING_NODE) return "a mapping";
  if (node->type == YAML_SEQUENCE_NODE) return "a list";
  if (node->type != YAML_SCALAR_NODE || node->data.scalar.length == 0) return "nothing";
  snprintf(out, 64, "'%s'", app_printable(quoted, sizeof quoted, scalar(node), node->data.scalar.length));
  return out;
}

static int wrong_type(const struct yaml_file *file, const yaml_node_t *node, const char *expected,
                      struct app_error *error) {
  char found[64];
  return yaml_fail(file, node, error, "expected %s, found %s", expected, describe(node, found));
}

/* ---- the file ---------------------------------------------------------------- */

static int syntax_error(const struct yaml_file *file, const yaml_parser_t *parser, struct app_error *error) {
  if (parser->error == YAML_MEMORY_ERROR) return app_fail(error, APP_FAILED, "%s: out of memory", file->path);
  const char *problem = parser->problem ? parser->problem : "cannot be read";
  if (parser->error == YAML_READER_ERROR) /* bytes that are no text: the mark does not tell where */
    return app_fail(error, APP_BAD_INPUT, "%s: not text: %s at byte %zu", file->path, problem,
                    parser->problem_offset);
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: not YAML: %s", file->path, parser->problem_mark.line + 1,
                  problem);
}

/* is there anything after the document? libyaml answers an empty document at the end */
static int check_single(struct yaml_file *file, yaml_parser_t *parser, struct app_error *error) {
  yaml_document_t next;
  if (!yaml_parser_load(parser, &next)) return syntax_error(file, parser, error);
  const yaml_node_t *root = yaml_document_get_root_node(&next);
  const int result = root ? yaml_fail(file, root, error, "a second document begins here, expected one") : 0;
  yaml_document_delete(&next);
  return result;
}

static int load(struct yaml_file *file, yaml_parser_t *parser, struct app_error *error) {
  if (!yaml_parser_load(parser, &file->document)) return syntax_error(file, parser, error);
  const yaml_node_t *root = yaml_document_get_root_node(&file->document);
  int result = 0;
  if (!root)
    result = app_fail(error, APP_BAD_INPUT, "%s: the file is empty, expected a model", file->path);
  else if (root->type != YAML_MAPPING_NODE)
    result = wrong_type(file, root, "a mapping (key: value)", error);
  else
    result = check_single(file, parser, error);
  if (result != 0) yaml_document_delete(&file->document);
  return result;
}

/* the file's bytes, at most a block of them */
static int read_text(struct yaml_file *file, struct text_block *block, struct app_error *error) {
  struct text_file *text = text_file_open(file->path, error);
  if (!text) return -1;
  int more = text_file_read(text, block, error);
  if (more == 0) block->length = 0;
  if (more > 0 && (block->endless || !text_file_ended(text)))
    more = app_fail(error, APP_BAD_INPUT, "%s: longer than %d bytes, not a model", file->path, TEXT_BLOCK);
  text_file_close(text);
  return more < 0 ? -1 : 0;
}

static int parse(struct yaml_file *file, const struct text_block *block, struct app_error *error) {
  yaml_parser_t parser;
  if (!yaml_parser_initialize(&parser)) return app_fail(error, APP_FAILED, "%s: out of memory", file->path);
  yaml_parser_set_input_string(&parser, (const unsigned char *)block->text, block->length);
  const int result = load(file, &parser, error);
  yaml_parser_delete(&parser);
  return result;
}

int yaml_file_open(struct yaml_file *file, const char *path, struct app_error *error) {
  struct text_block *block = malloc(sizeof *block);
  if (!block) return app_fail(error, APP_FAILED, "out of memory");
  file->path = path;
  file->key[0] = '\0';
  int result = read_text(file, block, error);
  if (result == 0) result = parse(file, block, error);
  free(block);
  return result;
}

void yaml_file_close(struct yaml_file *file) {
  yaml_document_delete(&file->document);
}

yaml_node_t *yaml_file_root(struct yaml_file *file) {
  return yaml_document_get_root_node(&file->document);
}

/* ---- mappings ---------------------------------------------------------------- */

static int is_key(const yaml_node_t *node, const char *key) {
  return node->type == YAML_SCALAR_NODE && node->data.scalar.length == strlen(key) &&
         strcmp(scalar(node), key) == 0;
}

yaml_node_t *yaml_find(struct yaml_file *file, const yaml_node_t *map, const char *key) {
  if (map->type != YAML_MAPPING_NODE) return NULL;
  for (const yaml_node_pair_t *pair = map->data.mapping.pairs.start; pair < map->data.mapping.pairs.top;
       pair++)
    if (is_key(yaml_document_get_node(&file->document, pair->key), key))
      return yaml_document_get_node(&file->document, pair->value);
  return NULL;
}

static int unknown_key(struct yaml_file *file, const yaml_node_t *key, const struct yaml_entry *entry,
                       size_t entries, struct app_error *error) {
  char known[300] = "", name[40];
  size_t used = 0;
  for (size_t i = 0; i < entries && used < sizeof known; i++)
    used += (size_t)snprintf(known + used, sizeof known - used, "%s%s", i ? ", " : "", entry[i].key);
  if (key->type != YAML_SCALAR_NODE) return wrong_type(file, key, "a key", error);
  yaml_key_enter(file, app_printable(name, sizeof name, scalar(key), key->data.scalar.length));
  return yaml_fail(file, key, error, "unknown key, expected one of %s", known);
}

/* one key and its value; `seen` marks the entries that were there */
static int read_pair(struct yaml_file *file, const yaml_node_pair_t *pair, const struct yaml_entry *entry,
                     size_t entries, unsigned long *seen, void *target, struct app_error *error) {
  const yaml_node_t *key = yaml_document_get_node(&file->document, pair->key);
  size_t i = 0;
  while (i < entries && !is_key(key, entry[i].key)) i++;
  if (i == entries) return unknown_key(file, key, entry, entries, error);
  const size_t before = yaml_key_enter(file, entry[i].key);
  if (*seen & 1ul << i) return yaml_fail(file, key, error, "the key stands twice");
  *seen |= 1ul << i;
  yaml_node_t *value = yaml_document_get_node(&file->document, pair->value);
  if (entry[i].read(file, value, &entry[i], target, error) != 0) return -1;
  yaml_key_leave(file, before);
  return 0;
}

int yaml_read_map(struct yaml_file *file, yaml_node_t *map, const struct yaml_entry *entry, size_t entries,
                  void *target, struct app_error *error) {
  unsigned long seen = 0;
  if (map->type != YAML_MAPPING_NODE) return wrong_type(file, map, "a mapping (key: value)", error);
  for (const yaml_node_pair_t *pair = map->data.mapping.pairs.start; pair < map->data.mapping.pairs.top;
       pair++)
    if (read_pair(file, pair, entry, entries, &seen, target, error) != 0) return -1;
  for (size_t i = 0; i < entries; i++)
    if (entry[i].required && !(seen & 1ul << i)) {
      yaml_key_enter(file, entry[i].key);
      return yaml_fail(file, map, error, "missing key");
    }
  return 0;
}

int yaml_read_section(struct yaml_file *file, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                      struct app_error *error) {
  return yaml_read_map(file, node, entry->map, entry->entries, (char *)target + entry->offset, error);
}

int yaml_read_later(struct yaml_file *file, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                    struct app_error *error) {
  (void)file, (void)error;
  yaml_node_t **place = (yaml_node_t **)(void *)((char *)target + entry->offset);
  *place = node;
  return 0;
}

/* ---- values ------------------------------------------------------------------ */

/* a plain scalar that is a finite decimal number from end to end */
static int parse_number(struct yaml_file *file, const yaml_node_t *node, double *x, struct app_error *error) {
  const char *end;
  if (node->type != YAML_SCALAR_NODE || node->data.scalar.style != YAML_PLAIN_SCALAR_STYLE)
    return wrong_type(file, node, "a number", error);
  const enum decimal_status status = decimal_parse(scalar(node), x, &end);
  if (status == DECIMAL_NOT_A_NUMBER || *end != '\0') return wrong_type(file, node, "a number", error);
  if (status == DECIMAL_NOT_FINITE) return wrong_type(file, node, "a finite number", error);
  return 0;
}

const char *yaml_range_fault(enum yaml_range range, double x) {
  switch (range) {
  case YAML_ANY: return NULL;
  case YAML_POSITIVE: return x > 0.0 ? NULL : "a number above 0";
  case YAML_NOT_NEGATIVE: return x >= 0.0 ? NULL : "0 or a number above it";
  case YAML_NOT_ZERO: return x != 0.0 ? NULL : "a number other than 0";
  }
  return NULL;
}

int yaml_read_number(struct yaml_file *file, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                     struct app_error *error) {
  double x = 0.0;
  if (parse_number(file, node, &x, error) != 0) return -1;
  const char *expected = yaml_range_fault(entry->range, x);
  if (expected) return wrong_type(file, node, expected, error);
  memcpy((char *)target + entry->offset, &x, sizeof x);
  return 0;
}

int yaml_read_whole(struct yaml_file *file, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                    struct app_error *error) {
  char expected[64];
  double x = 0.0;
  if (parse_number(file, node, &x, error) != 0) return -1;
  snprintf(expected, sizeof expected, "a whole number from %d to %d", entry->low, entry->high);
  if (x < entry->low || x > entry->high || x != (double)(int)x)
    return wrong_type(file, node, expected, error);
  const int whole = (int)x;
  memcpy((char *)target + entry->offset, &whole, sizeof whole);
  return 0;
}

int yaml_read_numbers(struct yaml_file *file, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                      struct app_error *error) {
  char expected[48];
  snprintf(expected, sizeof expected, "a list of %zu numbers", entry->length);
  if (node->type != YAML_SEQUENCE_NODE) return wrong_type(file, node, expected, error);
  const size_t n = (size_t)(node->data.sequence.items.top - node->data.sequence.items.start);
  if (n != entry->length) return yaml_fail(file, node, error, "expected %s, found %zu", expected, n);
  struct yaml_entry element = *entry;
  for (size_t i = 0; i < n; i++, element.offset += sizeof(double)) {
    yaml_node_t *item = yaml_document_get_node(&file->document, node->data.sequence.items.start[i]);
    if (yaml_read_number(file, item, &element, target, error) != 0) return -1;
  }
  return 0;
}

const char *yaml_text(struct yaml_file *file, const yaml_node_t *node, struct app_error *error) {
  if (node->type == YAML_SCALAR_NODE && strlen(scalar(node)) == node->data.scalar.length) return scalar(node);
  wrong_type(file, node, "a name", error);
  return NULL;
}

int yaml_read_name(struct yaml_file *file, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                   struct app_error *error) {
  const char *text = yaml_text(file, node, error);
  if (!text) return -1;
  memcpy((char *)target + entry->offset, &text, sizeof text);
  return 0;
}
