/* model_bus.c: what a model file says about the leg's bus, read and written. */
#include "model_bus.h"

#include <stddef.h>

#define MOST_COUNTS 65536 /* an absolute encoder's turn fits into the 16 bits of its field */
#define MOST_COUNTER 1048576

#define COUNT(table) (sizeof table / sizeof table[0])
#define PLACE(member) offsetof(struct model_bus_joint, member)
#define SIGN(member)                                                                                         \
  { .key = "sign", .required = 1, .read = read_sign, .offset = PLACE(member) }
#define COUNTS(member, most)                                                                                 \
  {                                                                                                          \
    .key = "counts_per_turn", .required = 1, .read = yaml_read_whole, .offset = PLACE(member), .low = 2,     \
    .high = most                                                                                             \
  }
#define SECTION(name, table)                                                                                 \
  { .key = name, .required = 1, .read = yaml_read_section, .map = table, .entries = COUNT(table) }

/* ---- reading ----------------------------------------------------------------------- */

static int read_sign(struct yaml_file *yaml, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                     struct app_error *error) {
  const struct yaml_entry number = {.offset = 0};
  double sign;
  if (yaml_read_number(yaml, node, &number, &sign, error) != 0) return -1;
  if (sign != 1.0 && sign != -1.0) return yaml_fail(yaml, node, error, "expected 1 or -1, found '%g'", sign);
  *(int *)(void *)((char *)target + entry->offset) = sign > 0.0 ? 1 : -1;
  return 0;
}

static const struct yaml_entry motor_keys[] = {COUNTS(motor_counts_per_turn, MOST_COUNTER), SIGN(motor_sign)};

static const struct yaml_entry joint_keys[] = {
    COUNTS(joint_counts_per_turn, MOST_COUNTS),
    SIGN(joint_sign),
    {.key = "zero_count",
     .required = 1,
     .read = yaml_read_number,
     .offset = PLACE(joint_zero_count),
     .range = YAML_NOT_NEGATIVE},
};

static const struct yaml_entry current_keys[] = {SIGN(current_sign)};

static const struct yaml_entry drive_keys[] = {
    SECTION("motor", motor_keys),
    SECTION("joint", joint_keys),
    SECTION("current", current_keys),
};

static int read_drive(struct yaml_file *yaml, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                      struct app_error *error) {
  struct model_bus_joint *joint = (void *)((char *)target + entry->offset);
  if (yaml_read_map(yaml, node, drive_keys, COUNT(drive_keys), joint, error) != 0) return -1;
  if (joint->joint_zero_count < joint->joint_counts_per_turn) return 0;
  yaml_key_enter(yaml, "joint.zero_count");
  return yaml_fail(yaml, node, error, "expected a count below counts_per_turn, %d",
                   joint->joint_counts_per_turn);
}

static const struct yaml_entry bus_keys[] = {
    {.key = "knee", .required = 1, .read = read_drive, .offset = offsetof(struct model_bus, joint[0])},
    {.key = "ankle", .required = 1, .read = read_drive, .offset = offsetof(struct model_bus, joint[1])},
};

int model_read_bus(struct yaml_file *yaml, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                   struct app_error *error) {
  struct model_file *file = &((struct model_draft *)target)->file;
  (void)entry;
  file->has_bus = 1;
  return yaml_read_map(yaml, node, bus_keys, COUNT(bus_keys), &file->bus, error);
}

/* ---- writing ----------------------------------------------------------------------- */

static void write_joint(struct output *out, const char *name, const struct model_bus_joint *joint) {
  output_printf(out, "  %s:\n    motor: {counts_per_turn: %d, sign: %d}\n", name,
                joint->motor_counts_per_turn, joint->motor_sign);
  output_printf(out, "    joint: {counts_per_turn: %d, sign: %d, zero_count: ", joint->joint_counts_per_turn,
                joint->joint_sign);
  output_exact(out, joint->joint_zero_count);
  output_printf(out, "}\n    current: {sign: %d}\n", joint->current_sign);
}

void model_write_bus(struct output *out, const struct model_file *file) {
  if (!file->has_bus) return;
  output_text(out, "bus:\n");
  write_joint(out, "knee", &file->bus.joint[0]);
  write_joint(out, "ankle", &file->bus.joint[1]);
}
