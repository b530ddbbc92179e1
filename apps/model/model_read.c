/* model_read.c: a model file from end to end. */
#include <stdio.h>
#include <string.h>

#include "model_keys.h"

/* "expected leg, pendulum or slider, found ..." */
static int unknown_plant(struct yaml_file *yaml, const yaml_node_t *node, const char *name,
                         struct app_error *error) {
  char names[256];
  size_t length = 0;
  for (int i = 0; i < TL_PLANT_COUNT && length < sizeof names; i++)
    length += (size_t)snprintf(names + length, sizeof names - length, "%s%s",
                               i == 0                    ? ""
                               : i == TL_PLANT_COUNT - 1 ? " or "
                                                         : ", ",
                               tl_plant_facts((tl_plant)i)->name);
  return yaml_fail(yaml, node, error, "expected %s, found '%.40s'", names, name);
}

/* the plant decides which keys there are, so it is looked up first, wherever it stands */
static int read_plant(struct yaml_file *yaml, tl_plant *plant, struct app_error *error) {
  yaml_node_t *root = yaml_file_root(yaml);
  const yaml_node_t *node = yaml_find(yaml, root, "plant");
  const size_t before = yaml_key_enter(yaml, "plant");
  if (!node) return yaml_fail(yaml, root, error, "missing key");
  const char *name = yaml_text(yaml, node, error);
  if (!name) return -1;
  if (tl_plant_find(name, plant) != TL_OK) return unknown_plant(yaml, node, name, error);
  yaml_key_leave(yaml, before);
  return 0;
}

static int read_model(struct yaml_file *yaml, struct model_draft *draft, struct app_error *error) {
  tl_plant plant = TL_PLANT_COUNT;
  struct model_table table;
  if (read_plant(yaml, &plant, error) != 0) return -1;
  if (tl_model_init(&draft->file.model, plant) != TL_OK) return app_fail(error, APP_FAILED, "unknown plant");
  draft->file.score = tl_score_defaults();
  model_keys(plant, &table);
  if (yaml_read_map(yaml, yaml_file_root(yaml), table.entry, table.entries, draft, error) != 0) return -1;
  if (model_read_bounds(yaml, draft, error) != 0) return -1;
  /* the tables hold every range; this is the library's own opinion of the whole */
  if (tl_model_check(&draft->file.model) != TL_OK)
    return yaml_fail(yaml, yaml_file_root(yaml), error, "the model as a whole is out of its physical range");
  return model_read_effects(yaml, draft, error);
}

int model_file_read(const char *path, struct model_file *file, struct app_error *error) {
  struct yaml_file yaml;
  struct model_draft draft;
  memset(&draft, 0, sizeof draft);
  if (yaml_file_open(&yaml, path, error) != 0) return -1;
  const int result = read_model(&yaml, &draft, error);
  yaml_file_close(&yaml);
  if (result == 0) *file = draft.file;
  return result;
}
