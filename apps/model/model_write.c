/* model_write.c: a model as YAML. */
#include <math.h>
#include <string.h>

#include "common/number.h"
#include "common/output.h"
#include "model_bus.h"
#include "model_keys.h"

/* A number that both this reader and YAML 1.1 (which wants a point before an exponent) take for
 * the same double: 1e-06 becomes 1.0e-06. */
static void put_number(struct output *out, double x) {
  char text[NUMBER_TEXT];
  number_exact(text, x);
  const char *exponent = strchr(text, 'e');
  if (!exponent || strchr(text, '.')) {
    output_text(out, text);
    return;
  }
  output_bytes(out, text, (size_t)(exponent - text));
  output_text(out, ".0");
  output_text(out, exponent);
}

/* "before", the number */
static void put(struct output *out, const char *before, double x) {
  output_text(out, before);
  put_number(out, x);
}

static void put_list(struct output *out, const char *before, const double *x, size_t n) {
  output_text(out, before);
  for (size_t i = 0; i < n; i++) put(out, i ? ", " : "[", x[i]);
  output_text(out, "]");
}

static void put_comment(struct output *out, const char *comment) {
  while (comment && *comment) {
    const size_t n = strcspn(comment, "\n");
    output_text(out, "# ");
    output_bytes(out, comment, n);
    output_text(out, "\n");
    comment += n + (comment[n] == '\n');
  }
}

static void put_transmission(struct output *out, const tl_transmission *t) {
  if (t->kind == TL_TRANSMISSION_SCREW_LINKAGE) {
    put(out, "{type: screw_linkage, lead_m: ", t->linkage.lead_m);
    put(out, ", AB_m: ", t->linkage.AB_m);
    put(out, ", BO_m: ", t->linkage.BO_m);
    put(out, ", AC_m: ", t->linkage.AC_m);
    put(out, ", BOF_deg: ", t->linkage.BOF_deg);
  } else if (t->kind == TL_TRANSMISSION_FOURIER) {
    put(out, "{type: fourier, omega: ", t->fourier.omega);
    put_list(out, ", a: ", t->fourier.a, TL_FOURIER_ORDER + 1);
    put_list(out, ", b: ", t->fourier.b, TL_FOURIER_ORDER);
  } else
    put(out, "{type: fixed, ratio: ", t->ratio);
  output_text(out, "}");
}

static void put_value(struct output *out, const tl_model *m, const tl_key *key) {
  const void *at = (const char *)m + key->offset;
  double x;
  if (key->kind == TL_KEY_TRANSMISSION) {
    put_transmission(out, at);
    return;
  }
  memcpy(&x, at, sizeof x);
  put_number(out, x);
}

/* a section of numbers alone stands on one line */
static int is_flat(const tl_key *key, int keys, size_t before) {
  for (int i = 0; i < keys; i++)
    if (key[i].kind == TL_KEY_TRANSMISSION || strchr(key[i].name + before, '.')) return 0;
  return 1;
}

static void put_line(struct output *out, const tl_model *m, const tl_key *key, int keys, size_t before) {
  for (int i = 0; i < keys; i++) {
    output_printf(out, "%s%s: ", i ? ", " : "{", key[i].name + before);
    put_value(out, m, &key[i]);
  }
  output_text(out, "}\n");
}

/* what a plant holds, each name from `before` on, its lines after `indent` */
static void put_keys(struct output *out, const tl_model *m, const tl_key *key, int keys, size_t before,
                     const char *indent) {
  for (int i = 0, n; i < keys; i += n) {
    const char *name = key[i].name + before;
    const size_t length = model_key_section(&key[i], keys - i, before, &n), inside = before + length + 1;
    output_printf(out, "%s%.*s:", indent, (int)(length ? length : strlen(name)), name);
    output_text(out, length && !is_flat(&key[i], n, inside) ? "\n" : " ");
    if (length == 0) {
      put_value(out, m, &key[i]);
      output_text(out, "\n");
    } else if (is_flat(&key[i], n, inside)) {
      put_line(out, m, &key[i], n, inside);
    } else {
      put_keys(out, m, &key[i], n, inside, "  "); /* deeper than a drive's friction no file goes */
    }
  }
}

static void put_settings(struct output *out, const struct model_file *file) {
  if (file->has_score) {
    put(out, "score: {lowpass_hz: ", file->score.lowpass_hz);
    output_printf(out, ", order: %d", file->score.order);
    put(out, ", standstill: ", file->score.standstill);
    put(out, ", guard_s: ", file->score.guard_s);
    put(out, ", trim_s: ", file->score.trim_s);
    output_text(out, "}\n");
  }
  if (file->has_window) {
    output_printf(out, "signal: {order: %d", file->window.order);
    put(out, ", window_s: ", file->window.length_s);
    output_text(out, "}\n");
  }
}

static void put_bounds(struct output *out, const struct model_file *file) {
  int n, any = 0;
  const tl_parameter *parameter = tl_parameters(&file->model, &n);
  for (int i = 0; i < n; i++) {
    if (!file->bounded[i]) continue;
    if (!any++) output_text(out, "bounds:\n");
    output_printf(out, "  %s: ", parameter[i].name);
    put(out, "[", file->lower[i]);
    put(out, ", ", file->upper[i]);
    output_text(out, "]\n");
  }
}

static void put_effects(struct output *out, const struct model_file *file) {
  if (file->effects) output_text(out, "effects:\n");
  for (int i = 0; i < file->effects; i++) {
    const tl_effect *e = &file->effect[i];
    const int n = e->kind->strengths + e->kind->shapes;
    output_printf(out, "  - effect: %s\n    joint: %s\n    parameters: {", e->kind->name,
                  model_effect_joint(&file->model, e->joint));
    for (int k = 0, any = 0; k < n; k++) {
      if (!tl_effect_says(e, k)) continue;
      output_printf(out, "%s%s: ", any++ ? ", " : "", e->kind->parameter[k].name);
      output_exact(out, e->value[k]);
    }
    output_text(out, "}\n");
  }
}

/* Can every number be written and read again? */
static int check(const char *path, const struct model_file *file, struct app_error *error) {
  const tl_model *m = &file->model;
  char key[128];
  const char *name = path ? path : "standard output";
  const char *expected = model_find_fault(file, key, sizeof key);
  if (expected) return app_fail(error, APP_FAILED, "%s: not written: %s is not %s", name, key, expected);
  if (tl_model_check(m) != TL_OK)
    return app_fail(error, APP_FAILED, "%s: not written: the model is out of its physical range", name);
  for (int j = 0; j < tl_joint_count(m); j++)
    if (m->drive[j].transmission.kind == TL_TRANSMISSION_TABLE)
      return app_fail(error, APP_FAILED, "%s: not written: a table as transmission has no file format", name);
  return 0;
}

int model_file_write(const char *path, const struct model_file *file, const char *comment,
                     struct app_error *error) {
  const tl_model *m = &file->model;
  int keys;
  const tl_key *key = tl_model_keys(m->plant, &keys);
  if (check(path, file, error) != 0) return -1;
  struct output *out = output_open(path, error);
  if (!out) return -1;
  put_comment(out, comment);
  output_printf(out, "plant: %s\n", tl_plant_facts(m->plant)->name);
  if (m->form == TL_FORM_PAPER) output_text(out, "form: paper\n");
  put_keys(out, m, key, keys, 0, "");
  model_write_bus(out, file);
  put_settings(out, file);
  put_bounds(out, file);
  put_effects(out, file);
  return output_commit(out, error);
}
