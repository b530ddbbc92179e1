/* model_keys.c: what may stand in a model file, plant by plant. */
#include "model_keys.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "model_bus.h"
#include "talus/filter.h"

#define PLACE(member) offsetof(struct model_draft, file.member)
#define NUMBER(name, member, limits)                                                                         \
  { .key = name, .required = 1, .read = yaml_read_number, .offset = PLACE(member), .range = limits }
#define OPTIONAL(name, member, limits)                                                                       \
  { .key = name, .read = yaml_read_number, .offset = PLACE(member), .range = limits }
#define SECTION(name, table)                                                                                 \
  {                                                                                                          \
    .key = name, .required = 1, .read = yaml_read_section, .map = table,                                     \
    .entries = sizeof table / sizeof table[0]                                                                \
  }
#define TRANSMISSION(index)                                                                                  \
  {                                                                                                          \
    .key = "transmission", .required = 1, .read = model_read_transmission,                                   \
    .offset = PLACE(model.drive[index].transmission)                                                         \
  }

/* ---- what every plant may have ----------------------------------------------- */

static int read_form(struct yaml_file *yaml, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                     struct app_error *error) {
  struct model_draft *draft = target;
  const char *text = yaml_text(yaml, node, error);
  (void)entry;
  if (!text) return -1;
  if (strcmp(text, "lagrange") == 0)
    draft->file.model.form = TL_FORM_LAGRANGE;
  else if (strcmp(text, "paper") != 0)
    return yaml_fail(yaml, node, error, "expected lagrange or paper, found '%s'", text);
  else if (draft->file.model.plant != TL_PLANT_LEG)
    return yaml_fail(yaml, node, error, "only a leg has the form 'paper'");
  else
    draft->file.model.form = TL_FORM_PAPER;
  return 0;
}

static const struct yaml_entry score_keys[] = {
    OPTIONAL("lowpass_hz", score.lowpass_hz, YAML_POSITIVE),
    {.key = "order",
     .read = yaml_read_whole,
     .offset = PLACE(score.order),
     .low = 1,
     .high = TL_LOWPASS_MAX_ORDER},
    OPTIONAL("standstill", score.standstill, YAML_NOT_NEGATIVE),
    OPTIONAL("guard_s", score.guard_s, YAML_NOT_NEGATIVE),
    OPTIONAL("trim_s", score.trim_s, YAML_NOT_NEGATIVE),
};

static int read_score(struct yaml_file *yaml, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                      struct app_error *error) {
  ((struct model_draft *)target)->file.has_score = 1;
  return yaml_read_section(yaml, node, entry, target, error);
}

static const struct yaml_entry signal_keys[] = {
    {.key = "order",
     .required = 1,
     .read = yaml_read_whole,
     .offset = PLACE(window.order),
     .low = 2,
     .high = TL_WINDOW_MAX_ORDER},
    NUMBER("window_s", window.length_s, YAML_POSITIVE),
};

static int read_signal(struct yaml_file *yaml, yaml_node_t *node, const struct yaml_entry *entry,
                       void *target, struct app_error *error) {
  ((struct model_draft *)target)->file.has_window = 1;
  return yaml_read_section(yaml, node, entry, target, error);
}

#define COMMON_KEYS                                                                                          \
  {.key = "form", .read = read_form},                                                                        \
      {.key = "score",                                                                                       \
       .read = read_score,                                                                                   \
       .map = score_keys,                                                                                    \
       .entries = sizeof score_keys / sizeof score_keys[0]},                                                 \
      {.key = "signal", .read = read_signal, .map = signal_keys, .entries = 2},                              \
      {.key = "bounds", .read = yaml_read_later, .offset = offsetof(struct model_draft, bounds)}, {          \
    .key = "effects", .read = yaml_read_later, .offset = offsetof(struct model_draft, effects)               \
  }

#define PLANT_KEY                                                                                            \
  { .key = "plant", .required = 1, .read = yaml_read_name, .offset = offsetof(struct model_draft, plant) }

/* ---- leg ----------------------------------------------------------------------- */

static const struct yaml_entry shank_keys[] = {
    NUMBER("length_m", model.shank_length_m, YAML_POSITIVE),
    NUMBER("mass_kg", model.shank_mass_kg, YAML_POSITIVE),
    NUMBER("com_m", model.shank_com_m, YAML_NOT_NEGATIVE),
    NUMBER("inertia_kg_m2", model.shank_inertia_kg_m2, YAML_POSITIVE),
};

static const struct yaml_entry foot_keys[] = {
    NUMBER("mass_kg", model.foot_mass_kg, YAML_POSITIVE),
    NUMBER("com_m", model.foot_com_m, YAML_NOT_NEGATIVE),
    NUMBER("inertia_kg_m2", model.foot_inertia_kg_m2, YAML_POSITIVE),
};

static const struct yaml_entry ankle_motor_keys[] = {
    NUMBER("mass_kg", model.ankle_motor_mass_kg, YAML_POSITIVE),
    NUMBER("com_m", model.ankle_motor_com_m, YAML_NOT_NEGATIVE),
};

#define FRICTION_KEYS(index)                                                                                 \
  NUMBER("coulomb_Nm", model.drive[index].coulomb_Nm, YAML_NOT_NEGATIVE),                                    \
      NUMBER("viscous_Nms_rad", model.drive[index].viscous_Nms_rad, YAML_NOT_NEGATIVE)

static const struct yaml_entry friction_0_keys[] = {FRICTION_KEYS(0)};
static const struct yaml_entry friction_1_keys[] = {FRICTION_KEYS(1)};

static const struct yaml_entry drive_0_keys[] = {
    TRANSMISSION(0),
    NUMBER("torque_constant_Nm_A", model.drive[0].torque_constant_Nm_A, YAML_POSITIVE),
    SECTION("friction", friction_0_keys),
};

static const struct yaml_entry ankle_keys[] = {
    TRANSMISSION(1),
    NUMBER("torque_constant_Nm_A", model.drive[1].torque_constant_Nm_A, YAML_POSITIVE),
    NUMBER("rotor_inertia_kg_m2", model.drive[1].rotor_inertia_kg_m2, YAML_POSITIVE),
    SECTION("friction", friction_1_keys),
};

static const struct yaml_entry leg_keys[] = {
    PLANT_KEY,
    NUMBER("gravity_m_s2", model.gravity_m_s2, YAML_NOT_NEGATIVE),
    SECTION("shank", shank_keys),
    SECTION("foot", foot_keys),
    SECTION("ankle_motor", ankle_motor_keys),
    SECTION("knee", drive_0_keys),
    SECTION("ankle", ankle_keys),
    COMMON_KEYS,
    {.key = "bus", .read = model_read_bus},
};

/* ---- pendulum -------------------------------------------------------------------- */

static const struct yaml_entry pendulum_keys[] = {
    PLANT_KEY,
    NUMBER("gravity_m_s2", model.gravity_m_s2, YAML_NOT_NEGATIVE),
    NUMBER("inertia_kg_m2", model.inertia_kg_m2, YAML_POSITIVE),
    NUMBER("gravity_moment_kg_m", model.gravity_moment_kg_m, YAML_NOT_NEGATIVE),
    NUMBER("gravity_zero_rad", model.gravity_zero_rad, YAML_ANY),
    OPTIONAL("torque_offset_Nm", model.torque_offset_Nm, YAML_ANY),
    SECTION("joint", drive_0_keys),
    COMMON_KEYS,
};

/* ---- slider ----------------------------------------------------------------------- */

static const struct yaml_entry slider_friction_keys[] = {
    NUMBER("coulomb_N", model.drive[0].coulomb_Nm, YAML_NOT_NEGATIVE),
    NUMBER("viscous_Ns_m", model.drive[0].viscous_Nms_rad, YAML_NOT_NEGATIVE),
};

static const struct yaml_entry slider_keys[] = {
    PLANT_KEY,
    NUMBER("mass_kg", model.mass_kg, YAML_POSITIVE),
    SECTION("friction", slider_friction_keys),
    NUMBER("force_offset_N", model.force_offset_N, YAML_ANY),
    COMMON_KEYS,
};

/* ---- by plant ----------------------------------------------------------------------- */

#define COUNT(table) (sizeof table / sizeof table[0])

const struct yaml_entry *model_keys(tl_plant plant, size_t *entries) {
  switch (plant) {
  case TL_PLANT_LEG: *entries = COUNT(leg_keys); return leg_keys;
  case TL_PLANT_PENDULUM: *entries = COUNT(pendulum_keys); return pendulum_keys;
  case TL_PLANT_SLIDER: *entries = COUNT(slider_keys); return slider_keys;
  }
  *entries = 0;
  return NULL;
}

/* the number in this table, or in one of its sections, that has this dotted key */
static const struct yaml_entry *find(const struct yaml_entry *entry, size_t entries, const char *dotted) {
  for (size_t i = 0; i < entries; i++) {
    const size_t n = strlen(entry[i].key);
    if (strncmp(entry[i].key, dotted, n) != 0) continue;
    if (dotted[n] == '\0' && entry[i].read == yaml_read_number) return &entry[i];
    if (dotted[n] == '.' && entry[i].map) return find(entry[i].map, entry[i].entries, dotted + n + 1);
  }
  return NULL;
}

int model_key_offset(tl_plant plant, const char *dotted, size_t *offset) {
  size_t entries;
  const struct yaml_entry *table = model_keys(plant, &entries);
  const struct yaml_entry *found = find(table, entries, dotted);
  if (!found || found->offset >= PLACE(model) + sizeof(tl_model)) return -1;
  *offset = found->offset - PLACE(model);
  return 0;
}

/* in this table or one of its sections; `key` holds the sections' names and a point so far */
static const char *find_fault(const struct model_draft *draft, const struct yaml_entry *entry, size_t entries,
                              char *key, size_t size) {
  const size_t before = strlen(key);
  for (size_t i = 0; i < entries; i++) {
    const char *fault = NULL;
    double x;
    snprintf(key + before, size - before, "%s%s", entry[i].key, entry[i].map ? "." : "");
    if (entry[i].map) fault = find_fault(draft, entry[i].map, entry[i].entries, key, size);
    if (entry[i].read == yaml_read_number) {
      memcpy(&x, (const char *)draft + entry[i].offset, sizeof x);
      fault = isfinite(x) ? yaml_range_fault(entry[i].range, x) : "a finite number";
    }
    if (fault) return fault;
  }
  key[before] = '\0';
  return NULL;
}

const char *model_find_fault(const struct model_file *file, char *key, size_t size) {
  struct model_draft draft = {.file = *file};
  size_t entries;
  const struct yaml_entry *table = model_keys(file->model.plant, &entries);
  /* what the file will not say cannot be wrong */
  if (!file->has_score) draft.file.score = tl_score_defaults();
  if (!file->has_window) draft.file.window.length_s = 1.0;
  key[0] = '\0';
  return find_fault(&draft, table, entries, key, size);
}
