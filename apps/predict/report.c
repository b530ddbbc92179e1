/* report.c: see report.h. */
#include "report.h"

#include <stdio.h>
#include <string.h>

#include "common/json_file.h"

static void score_row(struct report *report, const tl_rows *rows, int joint, size_t k, double t_s) {
  const double measured = tl_rows_measured(rows, k);
  const double residual = tl_rows_residual(rows, report->base, k), predicted = measured - residual;

  scored_add(&report->joint[joint], rows->kind[k], measured, residual);
  if (report->panels)
    torque_panels_add(report->panels, (size_t)joint, t_s, measured, &predicted,
                      rows->kind[k] == TL_ROW_SCORED);
}

static int score_part(const struct stream_part *part, void *context, struct app_error *error) {
  struct report *report = context;

  (void)error;
  for (int j = 0; j < tl_joint_count(report->model); j++) {
    const tl_rows *rows = &part->space->rows[j];
    for (size_t k = 0; k < rows->n; k++)
      score_row(report, rows, j, k, rows->begin_s + (double)k * part->regression->step_s);
  }
  return 0;
}

int report_make(struct report *report, const tl_model *model, struct stream *stream, int with_page,
                struct app_error *error) {
  static const struct torque_line line[] = {{"predicted", "predicted", "residual", 0}};

  memset(report, 0, sizeof *report);
  report->model = model;
  report->recording = stream_path(stream);
  tl_base_values(model, report->base);
  if (with_page) report->panels = torque_panels_new(line, 1, (size_t)tl_joint_count(model));
  if (with_page && !report->panels) return app_fail(error, APP_FAILED, "out of memory");
  stream_set_task(stream, "scoring");
  return stream_rows(stream, score_part, report, error);
}

void report_free(struct report *report) {
  torque_panels_free(report->panels);
}

/* ---- JSON ----------------------------------------------------------------------- */

static json_t *joint_json(const struct scored *joint, const tl_model *model) {
  json_t *one = json_object();

  json_set_text(one, "unit", scored_unit(model));
  json_set_number(one, "rms", scored_rms(joint));
  json_set_number(one, "measured_rms", scored_measured_rms(joint));
  json_set_number(one, "relative_percent", scored_relative_percent(joint));
  json_set_number(one, "reversal_rms", scored_reversal_rms(joint));
  json_object_set_new(one, "samples", json_integer((json_int_t)joint->rows));
  json_object_set_new(one, "samples_left_out", json_integer((json_int_t)joint->left_out));
  return one;
}

int report_write_json(const struct report *report, const char *path, struct app_error *error) {
  json_t *root = json_object(), *all = json_object();
  int result;

  for (int j = 0; j < tl_joint_count(report->model); j++)
    json_object_set_new(all, tl_joint_name(report->model, j), joint_json(&report->joint[j], report->model));
  json_set_text(root, "schema", "talus-predict/1");
  json_set_text(root, "recording", report->recording);
  json_object_set_new(root, "error", all);
  result = json_file_write(path, root, error);
  json_decref(root);
  return result;
}

/* ---- for people ------------------------------------------------------------------ */

int report_write_page(const struct report *report, const char *path, struct app_error *error) {
  const tl_model *m = report->model;
  const struct scored *joint[TL_MAX_JOINTS];
  char sentence[256];
  struct page *page;
  int result;

  for (int j = 0; j < TL_MAX_JOINTS; j++) joint[j] = &report->joint[j];
  scored_sentence(sentence, sizeof sentence, joint, m);
  page = page_new("Prediction", sentence);
  if (!page) return app_fail(error, APP_FAILED, "out of memory");
  page_heading(page, report->recording);
  for (int j = 0; j < tl_joint_count(m); j++)
    torque_panels_chart(report->panels, (size_t)j, page, tl_joint_name(m, j), scored_quantity(m),
                        scored_unit(m));
  result = page_write(page, path, error);
  page_free(page);
  return result;
}

void report_say(const struct report *report) {
  const tl_model *m = report->model;

  for (int j = 0; j < tl_joint_count(m); j++) {
    const struct scored *e = &report->joint[j];
    if (e->rows == 0)
      app_note("%s: no samples in motion, nothing to score", tl_joint_name(m, j));
    else
      fprintf(stderr,
              "%s: error %.1f %% of the measured %s (RMS %.4g of %.4g %s), %zu samples, %zu near "
              "standstill left out\n",
              tl_joint_name(m, j), scored_relative_percent(e), scored_quantity(m), scored_rms(e),
              scored_measured_rms(e), scored_unit(m), e->rows, e->left_out);
  }
}
