/* page.h: a report as one HTML page that needs nothing besides itself.
 *
 *     struct page *page = page_new("Identification of walk.csv", "The model explains the knee to 2.1 %.");
 *     const char *const columns[] = {"joint", "nominal", "identified"};
 *     page_table(page, "Error", columns, 3);
 *     page_table_row(page, cells);
 *     json_t *chart = page_chart(page, "Knee", "time [s]", "torque [Nm]");
 *     page_envelope(chart, "measured", "measured", &measured);
 *     json_t *below = page_chart_below(page, chart, "residual [Nm]");
 *     page_envelope(below, "residual", "residual", &residual);
 *     int result = page_write(page, path, &error);
 *     page_free(page);
 *
 * What is added appears in that order. Texts are plain text and are escaped here. A
 * series' role decides its colour, the same on every page: measured, predicted,
 * residual, nominal, identified, extended, noise, accent.
 *
 * The page holds its style, its script, the chart library and its data; it fits a phone, a
 * wide screen, dark mode and paper, and asks no network for anything.
 */
#ifndef PAGE_H
#define PAGE_H

#include "common/error.h"
#include "common/json_file.h"
#include "envelope.h"

struct page;

/* The heading, and the first sentence: what the reader should know if he reads no further. NULL when
 * out of memory. */
struct page *page_new(const char *title, const char *sentence);
/* Nullable: page. */
void page_free(struct page *page);

void page_heading(struct page *page, const char *text);
void page_paragraph(struct page *page, const char *text);
/* A table with n columns, the first of which names the rows; its rows follow. */
void page_table(struct page *page, const char *caption, const char *const *columns, size_t n);
void page_table_row(struct page *page, const char *const *cells);

/* A chart of lines; what it answers belongs to the page. */
json_t *page_chart(struct page *page, const char *title, const char *x_label, const char *y_label);
/* A lower chart right below `chart`, along the same x axis: residuals. */
json_t *page_chart_below(struct page *page, json_t *chart, const char *y_label);
/* A chart of dots instead of lines; the same calls fill it. */
json_t *page_dots(struct page *page, const char *title, const char *x_label, const char *y_label);
/* n horizontal bars with a label each. */
void page_bars(struct page *page, const char *title, const char *x_label, const char *const *labels,
               const double *values, size_t n);

/* A series: of a long recording, or of n points (NaN in y is a gap). */
void page_envelope(json_t *chart, const char *name, const char *role, const struct envelope *envelope);
void page_series(json_t *chart, const char *name, const char *role, const double *x, const double *y,
                 size_t n);

/* Writes atomically (output.h). 0, or -1 with status 1. */
int page_write(const struct page *page, const char *path, struct app_error *error);

#endif
