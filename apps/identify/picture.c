/* picture.c: the identification as a page; see report.h. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "page/page.h"
#include "report.h"

/* one joint of one recording */
struct panel {
  struct envelope measured, nominal, identified, residual, nominal_residual;
};

struct picture {
  int recordings, joints;
  struct panel panel[];
};

struct picture *picture_new(int recordings, int joints) {
  size_t n = (size_t)recordings * (size_t)joints;
  struct picture *p = malloc(sizeof *p + n * sizeof p->panel[0]);

  if (!p) return NULL;
  p->recordings = recordings;
  p->joints = joints;
  for (size_t i = 0; i < n; i++) {
    envelope_init(&p->panel[i].measured);
    envelope_init(&p->panel[i].nominal);
    envelope_init(&p->panel[i].identified);
    envelope_init(&p->panel[i].residual);
    envelope_init(&p->panel[i].nominal_residual);
  }
  return p;
}

void picture_free(struct picture *picture) {
  free(picture);
}

void picture_trace(const struct fit_instant *i, void *picture) {
  struct picture *p = picture;
  struct panel *panel = &p->panel[i->recording * p->joints + i->joint];
  int scored = i->kind == TL_ROW_SCORED;

  envelope_add(&panel->measured, i->t_s, i->measured);
  envelope_add(&panel->nominal, i->t_s, i->nominal);
  envelope_add(&panel->identified, i->t_s, i->identified);
  envelope_add(&panel->residual, i->t_s, scored ? i->measured - i->identified : (double)NAN);
  envelope_add(&panel->nominal_residual, i->t_s, scored ? i->measured - i->nominal : (double)NAN);
}

/* ---- tables ------------------------------------------------------------------ */

#define CELL 48

static void error_table(struct page *page, const struct report_input *in) {
  static const char *const columns[] = {"joint", "as given", "identified", "of the measured", "gap closed"};
  const tl_model *m = &in->prior->model;

  page_table(page, "RMS residual on the scored samples", columns, 5);
  for (int j = 0; j < tl_joint_count(m); j++) {
    const struct fit_error *e = &in->fit->error[j];
    double nominal = report_rms(e->nominal, e->scored), identified = report_rms(e->identified, e->scored);
    char cell[4][CELL];
    const char *cells[5] = {tl_joint_name(m, j), cell[0], cell[1], cell[2], cell[3]};

    snprintf(cell[0], CELL, "%.4g %s", nominal, report_unit(m));
    snprintf(cell[1], CELL, "%.4g %s", identified, report_unit(m));
    snprintf(cell[2], CELL, "%.2f %%", report_relative(e));
    snprintf(cell[3], CELL, "%.1f %%", nominal > 0.0 ? 100.0 * (1.0 - identified / nominal) : 0.0);
    if (e->scored == 0) cells[1] = cells[2] = cells[3] = cells[4] = "nothing to score";
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

/* ---- charts ------------------------------------------------------------------- */

static void charts(struct page *page, const struct picture *p, const struct report_input *in, int recording) {
  const tl_model *m = &in->prior->model;

  for (int j = 0; j < p->joints; j++) {
    const struct panel *panel = &p->panel[recording * p->joints + j];
    char axis[CELL], title[CELL];
    json_t *torque, *residual;

    snprintf(axis, sizeof axis, "%s [%s]", tl_plant_facts(m->plant)->torque_name, report_unit(m));
    snprintf(title, sizeof title, "%s", tl_joint_name(m, j));
    torque = page_chart(page, title, "time [s]", axis);
    page_envelope(torque, "as given", "nominal", &panel->nominal);
    page_envelope(torque, "measured", "measured", &panel->measured);
    page_envelope(torque, "identified", "identified", &panel->identified);
    snprintf(axis, sizeof axis, "residual [%s]", report_unit(m));
    residual = page_chart_below(page, torque, axis);
    page_envelope(residual, "as given", "nominal", &panel->nominal_residual);
    page_envelope(residual, "identified", "residual", &panel->residual);
  }
}

static void first_sentence(char *text, size_t size, const struct report_input *in) {
  const tl_model *m = &in->prior->model;
  int at = snprintf(text, size, "The identified model explains the measured torque to "), told = 0;

  for (int j = 0; j < tl_joint_count(m) && at < (int)size; j++) {
    if (in->fit->error[j].scored == 0) continue;
    at += snprintf(text + at, size - (size_t)at, "%s%.1f %% at the %s", told++ ? " and " : "",
                   report_relative(&in->fit->error[j]), tl_joint_name(m, j));
  }
  if (at < (int)size) snprintf(text + at, size - (size_t)at, ".");
  if (!told) snprintf(text, size, "No joint moves enough in these recordings to be scored.");
}

int picture_write(const struct picture *picture, const char *path, const struct report_input *in,
                  struct app_error *error) {
  char sentence[256];
  struct page *page;
  int result;

  first_sentence(sentence, sizeof sentence, in);
  page = page_new("Identification", sentence);
  if (!page) return app_fail(error, APP_FAILED, "out of memory");
  error_table(page, in);
  parameter_table(page, in);
  null_space_paragraphs(page, in);
  for (int i = 0; i < in->recordings; i++) {
    page_heading(page, in->path[i]);
    charts(page, picture, in, i);
  }
  result = page_write(page, path, error);
  page_free(page);
  return result;
}
