/* page.c: parts of a page, then its template with the parts put in. */
#include "page.h"

#include <stdlib.h>
#include <string.h>

#include "assets.h"

#define CHART_DIGITS 9 /* of each number of a chart */

struct page {
  char *title;
  json_t *parts; /* in order: {"kind": "heading" | "paragraph" | "table" | "chart", ...} */
};

/* ---- building ---------------------------------------------------------------- */

/* the new part belongs to the page */
static json_t *add_part(struct page *page, const char *kind) {
  json_t *part = json_object();
  json_set_text(part, "kind", kind);
  json_array_append_new(page->parts, part);
  return part;
}

static void add_text(struct page *page, const char *kind, const char *text) {
  json_set_text(add_part(page, kind), "text", text);
}

static json_t *texts(const char *const *text, size_t n) {
  json_t *list = json_array();
  for (size_t i = 0; i < n; i++) json_array_append_new(list, json_text(text[i]));
  return list;
}

struct page *page_new(const char *title, const char *sentence) {
  struct page *page = malloc(sizeof *page);
  if (!page) return NULL;
  page->title = strdup(title);
  page->parts = json_array();
  if (!page->title || !page->parts) {
    page_free(page);
    return NULL;
  }
  add_text(page, "title", title);
  add_text(page, "lead", sentence);
  return page;
}

void page_free(struct page *page) {
  if (!page) return;
  free(page->title);
  json_decref(page->parts);
  free(page);
}

void page_heading(struct page *page, const char *text) {
  add_text(page, "heading", text);
}

void page_paragraph(struct page *page, const char *text) {
  add_text(page, "paragraph", text);
}

void page_table(struct page *page, const char *caption, const char *const *columns, size_t n) {
  json_t *table = add_part(page, "table");
  json_set_text(table, "text", caption);
  json_object_set_new(table, "columns", texts(columns, n));
  json_object_set_new(table, "rows", json_array());
}

void page_table_row(struct page *page, const char *const *cells) {
  json_t *table = json_array_get(page->parts, json_array_size(page->parts) - 1);
  const size_t n = json_array_size(json_object_get(table, "columns"));
  json_array_append_new(json_object_get(table, "rows"), texts(cells, n));
}

static json_t *add_chart(struct page *page, const char *form, const char *title, const char *x,
                         const char *y) {
  json_t *chart = add_part(page, "chart");
  json_set_text(chart, "form", form);
  json_set_text(chart, "title", title);
  json_set_text(chart, "x", x);
  json_set_text(chart, "y", y);
  json_object_set_new(chart, "series", json_array());
  return chart;
}

json_t *page_chart(struct page *page, const char *title, const char *x_label, const char *y_label) {
  return add_chart(page, "lines", title, x_label, y_label);
}

json_t *page_dots(struct page *page, const char *title, const char *x_label, const char *y_label) {
  return add_chart(page, "dots", title, x_label, y_label);
}

json_t *page_chart_below(struct page *page, json_t *chart, const char *y_label) {
  json_t *below = json_object();
  (void)page;
  json_object_set(below, "form", json_object_get(chart, "form"));
  json_object_set(below, "title", json_object_get(chart, "title"));
  json_object_set(below, "x", json_object_get(chart, "x"));
  json_set_text(below, "y", y_label);
  json_object_set_new(below, "series", json_array());
  json_object_set_new(chart, "below", below);
  return below;
}

void page_bars(struct page *page, const char *title, const char *x_label, const char *const *labels,
               const double *values, size_t n) {
  json_t *chart = add_chart(page, "bars", title, x_label, "");
  json_object_set_new(chart, "labels", texts(labels, n));
  json_object_set_new(chart, "values", json_numbers(values, n));
}

void page_series(json_t *chart, const char *name, const char *role, const double *x, const double *y,
                 size_t n) {
  json_t *series = json_object();
  json_set_text(series, "name", name);
  json_set_text(series, "role", role);
  json_object_set_new(series, "t", json_numbers(x, n));
  json_object_set_new(series, "y", json_numbers(y, n));
  json_array_append_new(json_object_get(chart, "series"), series);
}

void page_envelope(json_t *chart, const char *name, const char *role, const struct envelope *envelope) {
  static double t[ENVELOPE_POINTS], y[ENVELOPE_POINTS];
  page_series(chart, name, role, t, y, envelope_points(envelope, t, y));
}

/* ---- HTML ---------------------------------------------------------------------- */

static void put_escaped(struct output *out, const char *text) {
  for (; *text; text++) switch (*text) {
    case '&': output_text(out, "&amp;"); break;
    case '<': output_text(out, "&lt;"); break;
    case '>': output_text(out, "&gt;"); break;
    case '"': output_text(out, "&quot;"); break;
    default: output_bytes(out, text, 1);
    }
}

static void put_element(struct output *out, const char *open, const char *text, const char *close) {
  output_text(out, open);
  put_escaped(out, text);
  output_text(out, close);
}

static const char *member(const json_t *object, const char *key) {
  const char *text = json_string_value(json_object_get(object, key));
  return text ? text : "";
}

static void put_cells(struct output *out, const json_t *cells, const char *first, const char *open,
                      const char *first_close, const char *close) {
  output_text(out, "<tr>");
  for (size_t i = 0; i < json_array_size(cells); i++)
    put_element(out, i ? open : first, json_string_value(json_array_get(cells, i)), i ? close : first_close);
  output_text(out, "</tr>\n");
}

static void put_table(struct output *out, const json_t *table) {
  const json_t *rows = json_object_get(table, "rows");
  put_element(out, "<div class=\"wide\"><table>\n<caption>", member(table, "text"), "</caption>\n<thead>");
  put_cells(out, json_object_get(table, "columns"), "<th scope=\"col\">", "<th scope=\"col\">", "</th>",
            "</th>");
  output_text(out, "</thead>\n<tbody>\n");
  for (size_t i = 0; i < json_array_size(rows); i++)
    put_cells(out, json_array_get(rows, i), "<th scope=\"row\">", "<td>", "</th>", "</td>");
  output_text(out, "</tbody></table></div>\n");
}

/* room for a chart; the script fills the canvases, in the order of the data */
static void put_canvas(struct output *out, const char *height, const char *title, const char *label) {
  output_printf(out, "<div class=\"plot %s\"><canvas role=\"img\" aria-label=\"", height);
  put_element(out, "", title, ": ");
  put_element(out, "", label, "\"></canvas></div>\n");
}

static void put_chart(struct output *out, const json_t *chart) {
  const json_t *below = json_object_get(chart, "below");
  put_element(out, "<figure>\n<figcaption>", member(chart, "title"), "</figcaption>\n");
  put_canvas(out, below ? "tall joined" : member(chart, "form"), member(chart, "title"), member(chart, "y"));
  if (below) put_canvas(out, "low", member(chart, "title"), member(below, "y"));
  output_text(out, "</figure>\n");
}

static void put_part(struct output *out, const json_t *part) {
  const char *kind = member(part, "kind"), *text = member(part, "text");
  if (strcmp(kind, "title") == 0) put_element(out, "<h1>", text, "</h1>\n");
  if (strcmp(kind, "lead") == 0) put_element(out, "<p class=\"lead\">", text, "</p>\n");
  if (strcmp(kind, "heading") == 0) put_element(out, "<h2>", text, "</h2>\n");
  if (strcmp(kind, "paragraph") == 0) put_element(out, "<p>", text, "</p>\n");
  if (strcmp(kind, "table") == 0) put_table(out, part);
  if (strcmp(kind, "chart") == 0) put_chart(out, part);
}

static void put_body(struct output *out, const struct page *page) {
  for (size_t i = 0; i < json_array_size(page->parts); i++) put_part(out, json_array_get(page->parts, i));
}

static void put_data(struct output *out, const struct page *page) {
  json_t *charts = json_array();
  for (size_t i = 0; i < json_array_size(page->parts); i++) {
    json_t *part = json_array_get(page->parts, i);
    if (strcmp(member(part, "kind"), "chart") == 0) json_array_append(charts, part);
  }
  json_write_embedded(out, charts, CHART_DIGITS);
  json_decref(charts);
}

static void put_place(struct output *out, const struct page *page, const char *place, size_t n) {
  if (strncmp(place, "title", n) == 0) put_escaped(out, page->title);
  if (strncmp(place, "style", n) == 0) output_bytes(out, asset_page_css, asset_page_css_size);
  if (strncmp(place, "body", n) == 0) put_body(out, page);
  if (strncmp(place, "data", n) == 0) put_data(out, page);
  if (strncmp(place, "library", n) == 0) output_bytes(out, asset_chart_js, asset_chart_js_size);
  if (strncmp(place, "script", n) == 0) output_bytes(out, asset_page_js, asset_page_js_size);
}

/* the template, each {{place}} replaced */
int page_write(const struct page *page, const char *path, struct app_error *error) {
  struct output *out = output_open(path, error);
  if (!out) return -1;
  const char *text = (const char *)asset_page_html, *open, *close;
  while ((open = strstr(text, "{{")) != NULL && (close = strstr(open, "}}")) != NULL) {
    output_bytes(out, text, (size_t)(open - text));
    put_place(out, page, open + 2, (size_t)(close - open) - 2);
    text = close + 2;
  }
  output_text(out, text);
  return output_commit(out, error);
}
