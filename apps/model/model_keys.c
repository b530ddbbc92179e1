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
  else if (!tl_plant_facts(draft->file.model.plant)->paper_form)
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

static const struct yaml_entry plant_key = {
    .key = "plant", .required = 1, .read = yaml_read_name, .offset = offsetof(struct model_draft, plant)};
static const struct yaml_entry common_keys[] = {
    {.key = "form", .read = read_form},
    {.key = "score",
     .read = read_score,
     .map = score_keys,
     .entries = sizeof score_keys / sizeof score_keys[0]},
    {.key = "signal", .read = read_signal, .map = signal_keys, .entries = 2},
    {.key = "bounds", .read = yaml_read_later, .offset = offsetof(struct model_draft, bounds)},
    {.key = "effects", .read = yaml_read_later, .offset = offsetof(struct model_draft, effects)},
    {.key = "bus", .read = model_read_bus}, /* last: of the leg alone */
};

/* ---- the plant's own, from its row of the library's table ---------------------- */

size_t model_key_section(const tl_key *key, int keys, size_t before, int *n) {
  const size_t length = strcspn(key->name + before, ".");
  *n = 1;
  if (key->name[before + length] == '\0') return 0;
  while (*n < keys && strncmp(key[*n].name, key->name, before + length + 1) == 0) ++*n;
  return length;
}

static struct yaml_entry leaf(const tl_key *key, const char *name) {
  static const enum yaml_range range[] = {[TL_KEY_ANY] = YAML_ANY,
                                          [TL_KEY_POSITIVE] = YAML_POSITIVE,
                                          [TL_KEY_NOT_NEGATIVE] = YAML_NOT_NEGATIVE,
                                          [TL_KEY_TRANSMISSION] = YAML_ANY};
  return (struct yaml_entry){.key = name,
                             .required = !key->optional,
                             .read = key->kind == TL_KEY_TRANSMISSION ? model_read_transmission
                                                                      : yaml_read_number,
                             .offset = PLACE(model) + key->offset,
                             .range = range[key->kind]};
}

/* a name's first `length` characters into the table's text; names that do not fit end it */
static const char *keep_name(struct model_table *t, const char *name, size_t length) {
  char *kept = t->text + t->length;
  if (t->length + length >= sizeof t->text) return "";
  memcpy(kept, name, length);
  kept[length] = '\0';
  t->length += length + 1;
  return kept;
}

/* one entry a key or section at `before` characters of the names, into `out`; answers how many */
static size_t put_entries(struct model_table *t, const tl_key *key, int keys, size_t before,
                          struct yaml_entry *out) {
  size_t entries = 0;
  for (int i = 0, n; i < keys && entries < MODEL_MAX_ENTRIES; i += n, entries++) {
    const char *name = key[i].name + before;
    const size_t length = model_key_section(&key[i], keys - i, before, &n);
    out[entries] = leaf(&key[i], name);
    if (length == 0 || t->sections == MODEL_MAX_SECTIONS) continue;
    struct yaml_entry *section = t->section[t->sections++];
    out[entries] = (struct yaml_entry){.key = keep_name(t, name, length),
                                       .required = 1,
                                       .read = yaml_read_section,
                                       .map = section,
                                       .entries = put_entries(t, &key[i], n, before + length + 1, section)};
  }
  return entries;
}

void model_keys(tl_plant plant, struct model_table *t) {
  const size_t common = sizeof common_keys / sizeof common_keys[0] - !tl_plant_facts(plant)->leg_bus;
  int n;
  const tl_key *key = tl_model_keys(plant, &n);
  t->sections = t->length = 0;
  t->entry[0] = plant_key;
  t->entries = 1 + put_entries(t, key, n, 0, t->entry + 1);
  memcpy(t->entry + t->entries, common_keys, common * sizeof common_keys[0]);
  t->entries += common;
}

int model_key_offset(tl_plant plant, const char *dotted, size_t *offset) {
  int n;
  const tl_key *key = tl_model_keys(plant, &n);
  for (int i = 0; i < n; i++) {
    if (key[i].kind == TL_KEY_TRANSMISSION || strcmp(key[i].name, dotted) != 0) continue;
    *offset = key[i].offset;
    return 0;
  }
  return -1;
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
  struct model_table table;
  model_keys(file->model.plant, &table);
  /* what the file will not say cannot be wrong */
  if (!file->has_score) draft.file.score = tl_score_defaults();
  if (!file->has_window) draft.file.window.length_s = 1.0;
  key[0] = '\0';
  return find_fault(&draft, table.entry, table.entries, key, size);
}
