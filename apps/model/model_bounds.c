/* model_bounds.c: `bounds:` of a model file. */
#include <string.h>

#include "model_keys.h"

/* which parameter a key of `bounds:` means, or -1: by its name, or by its place in the model */
static int find_parameter(const tl_model *model, const char *key) {
  int n;
  size_t offset;
  const tl_parameter *parameter = tl_parameters(model, &n);
  const int is_place = model_key_offset(model->plant, key, &offset) == 0;
  for (int i = 0; i < n; i++)
    if (strcmp(parameter[i].name, key) == 0 || (is_place && parameter[i].offset == offset)) return i;
  return -1;
}

static int check(struct yaml_file *yaml, const yaml_node_t *node, const struct model_file *file, int i,
                 struct app_error *error) {
  int n;
  double value[TL_MAX_PARAMETERS];
  const double lower = file->lower[i], upper = file->upper[i],
               physical = tl_parameters(&file->model, &n)[i].lower;
  tl_parameters_get(&file->model, value);
  if (lower > upper)
    return yaml_fail(yaml, node, error, "the lower bound %.15g is above the upper bound %.15g", lower, upper);
  if (lower < physical)
    return yaml_fail(yaml, node, error, "the lower bound %.15g is below the physical limit %.15g", lower,
                     physical);
  if (value[i] < lower || value[i] > upper)
    return yaml_fail(yaml, node, error, "the model's own value %.15g lies outside of [%.15g, %.15g]",
                     value[i], lower, upper);
  return 0;
}

static int read_bound(struct yaml_file *yaml, const yaml_node_t *key, yaml_node_t *value,
                      struct model_file *file, struct app_error *error) {
  static const struct yaml_entry pair = {.read = yaml_read_numbers, .length = 2};
  double bound[2];
  const char *name = yaml_text(yaml, key, error);
  if (!name) return -1;
  const size_t before = yaml_key_enter(yaml, name);
  const int i = find_parameter(&file->model, name);
  if (i < 0) return yaml_fail(yaml, key, error, "not a parameter that is identified");
  if (file->bounded[i]) return yaml_fail(yaml, key, error, "this parameter has a bound already");
  if (yaml_read_numbers(yaml, value, &pair, bound, error) != 0) return -1;
  file->bounded[i] = 1;
  file->lower[i] = bound[0];
  file->upper[i] = bound[1];
  if (check(yaml, value, file, i, error) != 0) return -1;
  yaml_key_leave(yaml, before);
  return 0;
}

int model_read_bounds(struct yaml_file *yaml, struct model_draft *draft, struct app_error *error) {
  const yaml_node_t *map = draft->bounds;
  if (!map) return 0;
  const size_t before = yaml_key_enter(yaml, "bounds");
  if (map->type != YAML_MAPPING_NODE)
    return yaml_fail(yaml, map, error, "expected a mapping of key: [lower, upper]");
  for (const yaml_node_pair_t *pair = map->data.mapping.pairs.start; pair < map->data.mapping.pairs.top;
       pair++) {
    const yaml_node_t *key = yaml_document_get_node(&yaml->document, pair->key);
    yaml_node_t *value = yaml_document_get_node(&yaml->document, pair->value);
    if (read_bound(yaml, key, value, &draft->file, error) != 0) return -1;
  }
  yaml_key_leave(yaml, before);
  return 0;
}
