/* picture.c: the identification as a page; see report.h. */
#include <stdio.h>
#include <stdlib.h>

#include "page/torque_panels.h"
#include "report.h"

struct picture {
  int joints;
  struct torque_panels *panels; /* of each joint of each recording */
};

struct picture *picture_new(int recordings, int joints) {
  static const struct torque_line line[] = {{"as given", "nominal", "nominal", 1},
                                            {"identified", "identified", "residual", 0}};
  struct picture *p = malloc(sizeof *p);

  if (!p) return NULL;
  p->joints = joints;
  p->panels = torque_panels_new(line, 2, (size_t)recordings * (size_t)joints);
  if (p->panels) return p;
  free(p);
  return NULL;
}

void picture_free(struct picture *picture) {
  if (picture) torque_panels_free(picture->panels);
  free(picture);
}

static size_t panel_of(const struct picture *p, int recording, int joint) {
  return (size_t)recording * (size_t)p->joints + (size_t)joint;
}

void picture_trace(const struct fit_instant *i, void *picture) {
  struct picture *p = picture;
  const double predicted[] = {i->nominal, i->identified};

  torque_panels_add(p->panels, panel_of(p, i->recording, i->joint), i->t_s, i->measured, predicted,
                    i->kind == TL_ROW_SCORED);
}

/* ---- tables ------------------------------------------------------------------ */

#define CELL 48

static void error_table(struct page *page, const struct report_input *in) {
  static const char *const columns[] = {"joint", "as given", "identified", "of the measured", "gap closed"};
  const tl_model *m = &in->prior->model;

  page_table(page, "RMS residual on the scored samples", columns, 5);
  for (int j = 0; j < tl_joint_count(m); j++) {
    const struct fit_error *e = &in->fit->error[j];
    double nominal = scored_rms(&e->nominal), identified = scored_rms(&e->identified);
    char cell[4][CELL];
    const char *cells[5] = {tl_joint_name(m, j), cell[0], cell[1], cell[2], cell[3]};

    snprintf(cell[0], CELL, "%.4g %s", nominal, scored_unit(m));
    snprintf(cell[1], CELL, "%.4g %s", identified, scored_unit(m));
    snprintf(cell[2], CELL, "%.2f %%", scored_relative_percent(&e->identified));
    snprintf(cell[3], CELL, "%.1f %%", nominal > 0.0 ? 100.0 * (1.0 - identified / nominal) : 0.0);
    if (e->identified.rows == 0) cells[1] = cells[2] = cells[3] = cells[4] = "nothing to score";
    page_table_row(page, cells);
  }
}

static void parameter_table(struct page *page, const struct report_input *in) {
  static const char *const columns[] = {"parameter", "given", "identified", "change", "standard deviation"};
  const tl_problem *p = &in->fit->problem;
  const tl_identify_result *r = &in->fit->result;
  const tl_parameter *table = tl_parameters(&p->model, &(int){0});

  page_table(page, "Parameters", columns, 5);
  for (int i = 0; i < p->parameters; i++) {
    char cell[4][CELL];
    const char *cells[5] = {table[i].name, cell[0], cell[1], cell[2], cell[3]};

    snprintf(cell[0], CELL, "%.5g", p->prior[i]);
    snprintf(cell[1], CELL, "%.5g", r->value[i]);
    snprintf(cell[2], CELL, "%+.1f %%", p->prior[i] != 0.0 ? 100.0 * (r->value[i] / p->prior[i] - 1.0) : 0.0);
    if (p->prior[i] == 0.0) cells[3] = "-";
    snprintf(cell[3], CELL, "%.2g", r->sigma[i]);
    if (r->hidden[i]) cells[4] = "unknown";
    if (!r->identifiable[i]) cells[4] = p->settings.fixed[i] ? "held" : "not identifiable";
    page_table_row(page, cells);
  }
}

static void null_space_paragraphs(struct page *page, const struct report_input *in) {
  char names[REPORT_TEXT], text[REPORT_TEXT + 32];
  unsigned told = 0;

  for (int k = 0; k < in->fit->result.null_count; k++) {
    if (!report_null_text(in, k, &told, names, sizeof names)) continue;
    snprintf(text, sizeof text, "Not identifiable: %s.", names);
    page_paragraph(page, text);
  }
}

static void inertia_paragraphs(struct page *page, const struct report_input *in) {
  char said[REPORT_TEXT], text[REPORT_TEXT + 8];

  for (int i = 0; i < in->fit->problem.parameters; i++) {
    if (!report_inertia_text(in, i, said, sizeof said)) continue;
    snprintf(text, sizeof text, "Note: %s.", said);
    page_paragraph(page, text);
  }
}

/* ---- the page ----------------------------------------------------------------- */

static void charts(struct page *page, const struct picture *p, const struct report_input *in, int recording) {
  const tl_model *m = &in->prior->model;

  page_heading(page, in->path[recording]);
  for (int j = 0; j < p->joints; j++)
    torque_panels_chart(p->panels, panel_of(p, recording, j), page, tl_joint_name(m, j), scored_quantity(m),
                        scored_unit(m));
}

int picture_write(const struct picture *picture, const char *path, const struct report_input *in,
                  struct app_error *error) {
  const struct scored *identified[TL_MAX_JOINTS];
  char sentence[256];
  struct page *page;
  int result;

  for (int j = 0; j < TL_MAX_JOINTS; j++) identified[j] = &in->fit->error[j].identified;
  scored_sentence(sentence, sizeof sentence, identified, &in->prior->model);
  page = page_new("Identification", sentence);
  if (!page) return app_fail(error, APP_FAILED, "out of memory");
  error_table(page, in);
  parameter_table(page, in);
  null_space_paragraphs(page, in);
  inertia_paragraphs(page, in);
  for (int i = 0; i < in->recordings; i++) charts(page, picture, in, i);
  result = page_write(page, path, error);
  page_free(page);
  return result;
}
