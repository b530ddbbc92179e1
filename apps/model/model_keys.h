/* model_keys.h: the keys of each plant's model file (private to model_*.c). */
#ifndef MODEL_KEYS_H
#define MODEL_KEYS_H

#include "model_file.h"
#include "yaml_map.h"

/* A model file while it is read. */
struct model_draft {
  struct model_file file;   /* offsets of the tables count from the draft, where this stands first */
  const char *plant, *form; /* as written, checked afterwards */
  yaml_node_t *bounds, *effects;
};

/* The keys of a plant's file, outermost mapping: a table of *entries. */
const struct yaml_entry *model_keys(tl_plant plant, size_t *entries);

/* The place in tl_model of a dotted key such as "knee.friction.coulomb_Nm"; 0 and *offset, or -1. */
int model_key_offset(tl_plant plant, const char *dotted, size_t *offset);

/* The first number of a model that is out of its range: its dotted key into `key`, how it
 * should be as the answer; NULL when all are in their ranges. */
const char *model_find_fault(const struct model_file *file, char *key, size_t size);

/* Reads draft->bounds, once everything else is in place. */
int model_read_bounds(struct yaml_file *yaml, struct model_draft *draft, struct app_error *error);
/* Reads draft->effects, once the rest of the model is in place. */
int model_read_effects(struct yaml_file *yaml, struct model_draft *draft, struct app_error *error);
/* Reads a transmission's mapping into the tl_transmission at the entry's offset. */
int model_read_transmission(struct yaml_file *yaml, yaml_node_t *node, const struct yaml_entry *entry,
                            void *target, struct app_error *error);

#endif
