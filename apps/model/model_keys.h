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

#define MODEL_MAX_ENTRIES 24 /* of a plant's own in one mapping */
#define MODEL_MAX_SECTIONS 12
/* The keys of a plant's file, made from tl_model_keys and what every plant may have. Stays where it is: its parts
 * point at each other. */
struct model_table {
  struct yaml_entry entry[MODEL_MAX_ENTRIES + 8]; /* the outermost mapping */
  size_t entries;
  struct yaml_entry section[MODEL_MAX_SECTIONS][MODEL_MAX_ENTRIES];
  size_t sections;
  char text[512]; /* the sections' names */
  size_t length;
};
void model_keys(tl_plant plant, struct model_table *table);

/* Does a section begin at `before` characters of a key's name? Its name's length, and in *n how many of the keys
 * stand in it; or 0 and 1. */
size_t model_key_section(const tl_key *key, int keys, size_t before, int *n);

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
