/* model_bus.h: the `bus:` of a leg's model file (private to model_*.c). */
#ifndef MODEL_BUS_H
#define MODEL_BUS_H

#include "common/output.h"
#include "model_keys.h"

/* For yaml_entry.read: the mapping into the draft's file. */
int model_read_bus(struct yaml_file *yaml, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                   struct app_error *error);
/* The same as text; nothing when the file has none. */
void model_write_bus(struct output *out, const struct model_file *file);

#endif
