/* setup.c: see setup.h. */
#include "track/setup.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "common/output.h"
#include "model/yaml_map.h"

static const char *const leg_name[4] = {"knee", "ankle", "heel", "toe"};

/* ---- reading --------------------------------------------------------------- */

struct marker_entry {
  tl_marker_color color;
  double x_px, y_px, radius_px;
};

struct view_entry {
  tl_marker_view view;
  const char *positive;
};

struct lamp_entry {
  double x_px, y_px, radius_px;
};

struct file_entry {
  yaml_node_t *markers, *view, *lamp;
  const char *lens;
};

#define NUMBER(type, name, field, must, kind)                                                                \
  { .key = name, .required = must, .read = yaml_read_number, .offset = offsetof(type, field), .range = kind }

static const struct yaml_entry marker_keys[] = {
    NUMBER(struct marker_entry, "hue_deg", color.hue_deg, 1, YAML_NOT_NEGATIVE),
    NUMBER(struct marker_entry, "hue_tolerance_deg", color.hue_tolerance_deg, 1, YAML_POSITIVE),
    NUMBER(struct marker_entry, "min_saturation", color.min_saturation, 1, YAML_POSITIVE),
    NUMBER(struct marker_entry, "min_value", color.min_value, 1, YAML_NOT_NEGATIVE),
    NUMBER(struct marker_entry, "x_px", x_px, 1, YAML_ANY),
    NUMBER(struct marker_entry, "y_px", y_px, 1, YAML_ANY),
    NUMBER(struct marker_entry, "radius_px", radius_px, 1, YAML_POSITIVE)};

static const struct yaml_entry view_keys[] = {
    {.key = "positive",
     .required = 1,
     .read = yaml_read_name,
     .offset = offsetof(struct view_entry, positive)},
    NUMBER(struct view_entry, "vertical_rad", view.vertical_rad, 1, YAML_ANY),
    NUMBER(struct view_entry, "shank_length_m", view.shank_length_m, 1, YAML_POSITIVE),
    NUMBER(struct view_entry, "shank_offset_rad", view.shank_offset_rad, 1, YAML_ANY),
    NUMBER(struct view_entry, "foot_offset_rad", view.foot_offset_rad, 1, YAML_ANY),
    {.key = "tilt",
     .read = yaml_read_numbers,
     .offset = offsetof(struct view_entry, view.tilt),
     .length = 2}};

static const struct yaml_entry lamp_keys[] = {
    NUMBER(struct lamp_entry, "x_px", x_px, 1, YAML_ANY),
    NUMBER(struct lamp_entry, "y_px", y_px, 1, YAML_ANY),
    NUMBER(struct lamp_entry, "radius_px", radius_px, 1, YAML_POSITIVE)};

static const struct yaml_entry file_keys[] = {
    {.key = "markers",
     .required = 1,
     .read = yaml_read_later,
     .offset = offsetof(struct file_entry, markers)},
    {.key = "view", .read = yaml_read_later, .offset = offsetof(struct file_entry, view)},
    {.key = "lamp", .read = yaml_read_later, .offset = offsetof(struct file_entry, lamp)},
    {.key = "lens", .read = yaml_read_name, .offset = offsetof(struct file_entry, lens)}};

#define COUNT(table) (sizeof(table) / sizeof(table)[0])

static int read_marker(struct yaml_file *file, const yaml_node_pair_t *pair, int m, struct setup *setup,
                       tl_marker_color *color, struct app_error *error) {
  struct marker_entry entry;
  tl_marker_classes classes;
  yaml_node_t *key = yaml_document_get_node(&file->document, pair->key);
  yaml_node_t *value = yaml_document_get_node(&file->document, pair->value);
  const char *name = yaml_text(file, key, error);
  if (!name) return -1;
  if (m >= TL_MARKER_MAX) return yaml_fail(file, key, error, "more than %d markers", TL_MARKER_MAX);
  if (strlen(name) >= SETUP_NAME || strpbrk(name, ", \t\"#") || !name[0])
    return yaml_fail(file, key, error, "a marker's name has 1 to %d letters", SETUP_NAME - 1);
  const size_t before = yaml_key_enter(file, name);
  if (yaml_read_map(file, value, marker_keys, COUNT(marker_keys), &entry, error) != 0) return -1;
  if (tl_marker_classes_init(&classes, &entry.color, 1) != TL_OK)
    return yaml_fail(file, value, error,
                     "expected hue_deg 0 to 360, its tolerance below 90, saturation and value to 1");
  if (!(entry.radius_px >= 1.5 && entry.radius_px <= 500.0 && fabs(entry.x_px) < 1e5 &&
        fabs(entry.y_px) < 1e5))
    return yaml_fail(file, value, error, "expected radius_px from 1.5 to 500 and a place in a picture");
  yaml_key_leave(file, before);
  snprintf(setup->name[m], SETUP_NAME, "%s", name);
  *color = entry.color;
  setup->mark.start_px[m][0] = entry.x_px;
  setup->mark.start_px[m][1] = entry.y_px;
  setup->mark.radius_px[m] = entry.radius_px;
  return 0;
}

static int read_markers(struct yaml_file *file, yaml_node_t *node, struct setup *setup,
                        tl_marker_color color[TL_MARKER_MAX], struct app_error *error) {
  int m = 0;
  const size_t before = yaml_key_enter(file, "markers");
  if (node->type != YAML_MAPPING_NODE || node->data.mapping.pairs.start == node->data.mapping.pairs.top)
    return yaml_fail(file, node, error, "expected a mapping of one to %d markers", TL_MARKER_MAX);
  for (const yaml_node_pair_t *pair = node->data.mapping.pairs.start; pair < node->data.mapping.pairs.top;
       pair++, m++)
    if (read_marker(file, pair, m, setup, &color[m < TL_MARKER_MAX ? m : 0], error) != 0) return -1;
  yaml_key_leave(file, before);
  setup->mark.markers = m;
  return 0;
}

static int read_view(struct yaml_file *file, yaml_node_t *node, struct setup *setup,
                     struct app_error *error) {
  struct view_entry entry;
  memset(&entry, 0, sizeof entry);
  const size_t before = yaml_key_enter(file, "view");
  if (yaml_read_map(file, node, view_keys, COUNT(view_keys), &entry, error) != 0) return -1;
  entry.view.clockwise = strcmp(entry.positive, "clockwise") == 0;
  if (!entry.view.clockwise && strcmp(entry.positive, "counterclockwise") != 0)
    return yaml_fail(file, node, error, "positive: expected clockwise or counterclockwise");
  if (!(hypot(entry.view.tilt[0], entry.view.tilt[1]) < 1.0))
    return yaml_fail(file, node, error, "tilt: expected slopes below 1");
  yaml_key_leave(file, before);
  setup->view = entry.view;
  return 0;
}

static int read_lamp(struct yaml_file *file, yaml_node_t *node, struct setup *setup,
                     struct app_error *error) {
  struct lamp_entry entry;
  const size_t before = yaml_key_enter(file, "lamp");
  if (yaml_read_map(file, node, lamp_keys, COUNT(lamp_keys), &entry, error) != 0) return -1;
  yaml_key_leave(file, before);
  setup->has_lamp = 1;
  setup->lamp_px[0] = entry.x_px;
  setup->lamp_px[1] = entry.y_px;
  setup->lamp_px[2] = entry.radius_px;
  return 0;
}

static int read_lens(const char *path, const char *named, struct setup *setup, struct app_error *error) {
  char beside[1200], text[FACE_TEXT];
  const char *slash = strrchr(path, '/');
  const int folder = slash && named[0] != '/' ? (int)(slash - path + 1) : 0;
  if (strlen(named) >= sizeof setup->lens_path || folder > 600)
    return app_fail(error, APP_BAD_INPUT, "%s: lens: the path is too long", path);
  snprintf(setup->lens_path, sizeof setup->lens_path, "%s", named);
  snprintf(beside, sizeof beside, "%.*s%s", folder, path, named);
  if (face_lens_read(beside, &setup->lens, text) != 0)
    return app_fail(error, APP_BAD_INPUT, "%s: %s", beside, text);
  setup->view.focal_px = setup->lens.focal_px[0];
  setup->view.center_px[0] = setup->lens.center_px[0];
  setup->view.center_px[1] = setup->lens.center_px[1];
  return 0;
}

static int read_parts(struct yaml_file *file, const char *path, struct setup *setup,
                      struct app_error *error) {
  tl_marker_color color[TL_MARKER_MAX];
  struct file_entry entry;
  memset(&entry, 0, sizeof entry);
  memset(color, 0, sizeof color);
  if (yaml_read_map(file, yaml_file_root(file), file_keys, COUNT(file_keys), &entry, error) != 0) return -1;
  if (read_markers(file, entry.markers, setup, color, error) != 0) return -1;
  if (entry.view && read_view(file, entry.view, setup, error) != 0) return -1;
  if (entry.lamp && read_lamp(file, entry.lamp, setup, error) != 0) return -1;
  if (entry.lens && read_lens(path, entry.lens, setup, error) != 0) return -1;
  setup_complete(setup, color);
  return 0;
}

int setup_read(const char *path, struct setup *setup, struct app_error *error) {
  struct yaml_file file;
  memset(setup, 0, sizeof *setup);
  if (yaml_file_open(&file, path, error) != 0) return -1;
  const int result = read_parts(&file, path, setup, error);
  yaml_file_close(&file);
  return result;
}

/* ---- what follows from it ----------------------------------------------------- */

static void share_colors(struct setup *setup, const tl_marker_color color[TL_MARKER_MAX]) {
  setup->mark.colors = 0;
  for (int m = 0; m < setup->mark.markers; m++) {
    int c = 0;
    while (c < setup->mark.colors && fabs(setup->mark.color[c].hue_deg - color[m].hue_deg) > 1e-6) c++;
    if (c == setup->mark.colors) setup->mark.color[setup->mark.colors++] = color[m];
    setup->mark.color_of[m] = c;
  }
}

void setup_complete(struct setup *setup, const tl_marker_color color[TL_MARKER_MAX]) {
  share_colors(setup, color);
  setup->is_leg = setup->mark.markers == 4 && setup->view.shank_length_m > 0.0;
  for (int m = 0; m < 4 && setup->is_leg; m++)
    if (strcmp(setup->name[m], leg_name[m]) != 0) setup->is_leg = 0;
  setup->mark.links = setup->is_leg ? 2 : 0;
  for (int k = 0; k < 2; k++) {
    setup->mark.link[k][0] = 2 * k;
    setup->mark.link[k][1] = 2 * k + 1;
  }
}

void setup_undistort(const struct setup *setup, const tl_marker_sample *in, tl_marker_sample *out) {
  double point[TL_MARKER_MAX][2];
  for (int m = 0; m < setup->mark.markers; m++) {
    out[m] = in[m];
    point[m][0] = in[m].x_px;
    point[m][1] = in[m].y_px;
  }
  if (!setup->lens_path[0]) return;
  face_lens_undistort(&setup->lens, point, setup->mark.markers);
  for (int m = 0; m < setup->mark.markers; m++) {
    out[m].x_px = point[m][0];
    out[m].y_px = point[m][1];
  }
}

/* ---- writing --------------------------------------------------------------- */

static void write_number(struct output *out, const char *before, double x) {
  output_text(out, before);
  output_number(out, x);
}

static void write_markers(struct output *out, const struct setup *setup) {
  output_text(out, "markers:\n");
  for (int m = 0; m < setup->mark.markers; m++) {
    const tl_marker_color *color = &setup->mark.color[setup->mark.color_of[m]];
    output_printf(out, "  %s:", setup->name[m]);
    write_number(out, " {hue_deg: ", color->hue_deg);
    write_number(out, ", hue_tolerance_deg: ", color->hue_tolerance_deg);
    write_number(out, ", min_saturation: ", color->min_saturation);
    write_number(out, ", min_value: ", color->min_value);
    write_number(out, ", x_px: ", setup->mark.start_px[m][0]);
    write_number(out, ", y_px: ", setup->mark.start_px[m][1]);
    write_number(out, ", radius_px: ", setup->mark.radius_px[m]);
    output_text(out, "}\n");
  }
}

static void write_view(struct output *out, const tl_marker_view *view) {
  output_printf(out, "view:\n  positive: %s   # as seen in the picture\n",
                view->clockwise ? "clockwise" : "counterclockwise");
  write_number(out, "  vertical_rad: ", view->vertical_rad);
  write_number(out, "\n  shank_length_m: ", view->shank_length_m);
  write_number(out, "\n  shank_offset_rad: ", view->shank_offset_rad);
  write_number(out, "\n  foot_offset_rad: ", view->foot_offset_rad);
  write_number(out, "\n  tilt: [", view->tilt[0]);
  write_number(out, ", ", view->tilt[1]);
  output_text(out, "]\n");
}

int setup_write(const char *path, const struct setup *setup, struct app_error *error) {
  struct output *out = output_open(path, error);
  if (!out) return -1;
  write_markers(out, setup);
  if (setup->view.shank_length_m > 0.0) write_view(out, &setup->view);
  if (setup->lens_path[0]) output_printf(out, "lens: %s\n", setup->lens_path);
  if (setup->has_lamp) {
    write_number(out, "lamp: {x_px: ", setup->lamp_px[0]);
    write_number(out, ", y_px: ", setup->lamp_px[1]);
    write_number(out, ", radius_px: ", setup->lamp_px[2]);
    output_text(out, "}\n");
  }
  return output_commit(out, error);
}
