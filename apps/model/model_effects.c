/* model_effects.c: `effects:` of a model file. */
#include <stdio.h>
#include <string.h>

#include "model_keys.h"

/* The joint's number of a name: knee, ankle, joint, slider, or base (TL_MAX_JOINTS); -1 for another. */
static int find_joint(const tl_model *m, const char *name) {
  if (strcmp(name, "base") == 0) return TL_MAX_JOINTS;
  for (int j = 0; j < tl_joint_count(m); j++)
    if (strcmp(tl_joint_name(m, j), name) == 0) return j;
  return -1;
}

const char *model_effect_joint(const tl_model *m, int joint) {
  return joint == TL_MAX_JOINTS ? "base" : tl_joint_name(m, joint);
}

static int read_parameters(struct yaml_file *yaml, yaml_node_t *node, tl_effect *e, struct app_error *error) {
  struct yaml_entry entry[TL_EFFECT_MAX_PARAMETERS];
  const int n = e->kind->strengths + e->kind->shapes;
  memset(entry, 0, sizeof entry);
  for (int i = 0; i < n; i++) {
    const tl_effect_parameter *p = &e->kind->parameter[i];
    e->value[i] = p->default_value;
    entry[i] = (struct yaml_entry){.key = p->name,
                                   .required = !(p->flags & TL_PARAMETER_OPTIONAL),
                                   .read = yaml_read_number,
                                   .offset = offsetof(tl_effect, value) + (size_t)i * sizeof(double)};
  }
  if (yaml_read_map(yaml, node, entry, (size_t)n, e, error) != 0) return -1;
  for (int i = 0; i < n; i++) {
    const tl_effect_parameter *p = &e->kind->parameter[i];
    if (!(e->value[i] >= p->low && e->value[i] <= p->high)) {
      yaml_key_enter(yaml, p->name);
      return yaml_fail(yaml, yaml_find(yaml, node, p->name), error,
                       "%.15g is out of its range, %.15g to %.15g", e->value[i], p->low, p->high);
    }
  }
  return 0;
}

/* the three keys of an effect, as written */
struct written {
  const char *effect, *joint;
  yaml_node_t *parameters;
};

static int read_effect(struct yaml_file *yaml, yaml_node_t *node, struct model_file *file,
                       struct app_error *error) {
  static const struct yaml_entry keys[] = {
      {.key = "effect", .required = 1, .read = yaml_read_name, .offset = offsetof(struct written, effect)},
      {.key = "joint", .required = 1, .read = yaml_read_name, .offset = offsetof(struct written, joint)},
      {.key = "parameters",
       .required = 1,
       .read = yaml_read_later,
       .offset = offsetof(struct written, parameters)},
  };
  struct written w = {NULL, NULL, NULL};
  tl_effect *e = &file->effect[file->effects];

  if (file->effects == MODEL_MAX_EFFECTS)
    return yaml_fail(yaml, node, error, "more than %d effects", MODEL_MAX_EFFECTS);
  /* an unknown effect first: what else it may have is then unknown too */
  const yaml_node_t *id = yaml_find(yaml, node, "effect");
  if (!id || id->type != YAML_SCALAR_NODE) return yaml_fail(yaml, node, error, "expected {effect: ID, ...}");
  const char *name = yaml_text(yaml, id, error);
  if (!name) return -1;
  e->kind = tl_effect_find(name);
  if (!e->kind) return yaml_fail(yaml, id, error, "the effect '%.40s' is not known to this version", name);
  if (yaml_read_map(yaml, node, keys, 3, &w, error) != 0) return -1;
  e->joint = find_joint(&file->model, w.joint);
  if (!tl_effect_applies(e->kind, &file->model, e->joint))
    return yaml_fail(yaml, node, error, "the effect '%s' cannot stand at '%.40s'", e->kind->name, w.joint);
  const size_t before = yaml_key_enter(yaml, "parameters");
  if (read_parameters(yaml, w.parameters, e, error) != 0) return -1;
  yaml_key_leave(yaml, before);
  if (tl_effect_check(e, &file->model) != TL_OK)
    return yaml_fail(yaml, node, error, "the linkage does not close, or there is none, with this '%s'",
                     e->kind->name);
  if (tl_effect_repeats(file->effect, file->effects))
    return yaml_fail(yaml, node, error, "a second '%s' at '%.40s': two of them have no sum, expected one",
                     e->kind->name, w.joint);
  file->effects++;
  return 0;
}

int model_read_effects(struct yaml_file *yaml, struct model_draft *draft, struct app_error *error) {
  yaml_node_t *list = draft->effects;
  if (!list) return 0;
  const size_t before = yaml_key_enter(yaml, "effects");
  if (list->type != YAML_SEQUENCE_NODE) return yaml_fail(yaml, list, error, "expected a list of effects");
  for (const yaml_node_item_t *i = list->data.sequence.items.start; i < list->data.sequence.items.top; i++) {
    if (read_effect(yaml, yaml_document_get_node(&yaml->document, *i), &draft->file, error) != 0) return -1;
  }
  yaml_key_leave(yaml, before);
  return 0;
}
