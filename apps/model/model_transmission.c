/* model_transmission.c: the three transmissions of a model file. */
#include <string.h>

#include "model_keys.h"
#include "talus/transmission.h"

/* The numbers of any of them, and its kind. */
struct dimensions {
  const char *type;
  double ratio;
  tl_screw_linkage linkage;
  tl_fourier fourier;
};

#define PLACE(member) offsetof(struct dimensions, member)
#define NUMBER(name, member, limits)                                                                         \
  { .key = name, .required = 1, .read = yaml_read_number, .offset = PLACE(member), .range = limits }
#define TYPE                                                                                                 \
  { .key = "type", .required = 1, .read = read_type, .offset = PLACE(type) }

static int read_type(struct yaml_file *yaml, yaml_node_t *node, const struct yaml_entry *entry, void *target,
                     struct app_error *error) {
  const char *text = yaml_text(yaml, node, error);
  if (!text) return -1;
  memcpy((char *)target + entry->offset, &text, sizeof text);
  return 0;
}

static const struct yaml_entry fixed_keys[] = {TYPE, NUMBER("ratio", ratio, YAML_NOT_ZERO)};

static const struct yaml_entry linkage_keys[] = {
    TYPE,
    NUMBER("lead_m", linkage.lead_m, YAML_POSITIVE),
    NUMBER("AB_m", linkage.AB_m, YAML_POSITIVE),
    NUMBER("BO_m", linkage.BO_m, YAML_POSITIVE),
    NUMBER("AC_m", linkage.AC_m, YAML_NOT_NEGATIVE),
    NUMBER("BOF_deg", linkage.BOF_deg, YAML_ANY),
};

static const struct yaml_entry fourier_keys[] = {
    TYPE,
    NUMBER("omega", fourier.omega, YAML_POSITIVE),
    {.key = "a",
     .required = 1,
     .read = yaml_read_numbers,
     .offset = PLACE(fourier.a),
     .length = TL_FOURIER_ORDER + 1},
    {.key = "b",
     .required = 1,
     .read = yaml_read_numbers,
     .offset = PLACE(fourier.b),
     .length = TL_FOURIER_ORDER},
};

static tl_status make_fixed(tl_transmission *t, const struct dimensions *d) {
  return tl_transmission_fixed(t, d->ratio);
}

static tl_status make_linkage(tl_transmission *t, const struct dimensions *d) {
  return tl_transmission_screw_linkage(t, &d->linkage);
}

static tl_status make_fourier(tl_transmission *t, const struct dimensions *d) {
  return tl_transmission_fourier(t, &d->fourier);
}

static const struct kind {
  const char *name;
  const struct yaml_entry *keys;
  size_t n;
  tl_status (*make)(tl_transmission *t, const struct dimensions *d);
  const char *fault; /* when the numbers are sound one by one, but not together */
} kinds[] = {
    {"fixed", fixed_keys, 2, make_fixed, "not a usable ratio"},
    {"screw_linkage", linkage_keys, 6, make_linkage,
     "this linkage does not close, or its ratio changes sign, within +-30 degrees"},
    {"fourier", fourier_keys, 4, make_fourier, "the ratio of this series changes sign within +-30 degrees"},
};

static const struct kind *find_kind(const char *name) {
  for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++)
    if (strcmp(kinds[i].name, name) == 0) return &kinds[i];
  return NULL;
}

/* the kind comes first, wherever it stands: it decides which keys there are */
static const struct kind *read_kind(struct yaml_file *yaml, const yaml_node_t *map, struct app_error *error) {
  const yaml_node_t *type = yaml_find(yaml, map, "type");
  const size_t before = yaml_key_enter(yaml, "type");
  const struct kind *kind = NULL;
  const char *name = NULL;
  if (!type)
    yaml_fail(yaml, map, error, "missing key");
  else if ((name = yaml_text(yaml, type, error)) != NULL && (kind = find_kind(name)) == NULL)
    yaml_fail(yaml, type, error, "expected fixed, screw_linkage or fourier, found '%.40s'", name);
  yaml_key_leave(yaml, before);
  return kind;
}

int model_read_transmission(struct yaml_file *yaml, yaml_node_t *node, const struct yaml_entry *entry,
                            void *target, struct app_error *error) {
  struct dimensions d;
  tl_transmission transmission;
  if (node->type != YAML_MAPPING_NODE)
    return yaml_fail(yaml, node, error, "expected a mapping {type: ..., ...}");
  const struct kind *kind = read_kind(yaml, node, error);
  memset(&d, 0, sizeof d);
  if (!kind || yaml_read_map(yaml, node, kind->keys, kind->n, &d, error) != 0) return -1;
  if (kind->make(&transmission, &d) != TL_OK) return yaml_fail(yaml, node, error, "%s", kind->fault);
  memcpy((char *)target + entry->offset, &transmission, sizeof transmission);
  return 0;
}
