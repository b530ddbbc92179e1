/* comparison.c: see comparison.h. */
#include "comparison.h"

#include <stdio.h>
#include <string.h>

#include "common/json_file.h"
#include "common/output.h"

enum { JOINTS = TL_CONTROLLER_JOINTS };

/* what is run, and with what result; the first is the bench without feedforward */
struct entry {
  const char *path; /* NULL: none */
  struct model_file file;
  struct controller controller;
  struct lockstep_result result;
};

struct entries {
  struct entry *entry;
  int n;
  struct model_file truth;
  struct trajectory motion;
  struct picture *picture; /* NULL: none */
};

/* ---- before ------------------------------------------------------------------------ */

/* the bench's and all models, before anything is run */
static int read_models(const struct comparison *c, struct entries *all, struct app_error *error) {
  if (model_file_read(c->truth, &all->truth, error) != 0) return -1;
  if (!all->truth.has_bus)
    return app_fail(error, APP_BAD_INPUT,
                    "%s: bus: missing key, --twin needs it (models/leg_bench.yaml has one)", c->truth);
  for (int i = 1; i < all->n; i++) {
    struct entry *e = &all->entry[i];
    if (model_file_read(e->path, &e->file, error) != 0) return -1;
    if (controller_make(&e->file, e->path, &c->drives, &e->controller, error) != 0) return -1;
    e->file.bus = all->truth.bus; /* how the bench counts is the bench's to say */
  }
  return 0;
}

static int run_all(const struct comparison *c, struct entries *all, struct app_error *error) {
  const struct lockstep l = {
      &all->truth, &all->motion, c->speed_lag_s, c->seed, all->picture ? picture_see : NULL, all->picture};

  for (int i = 0; i < all->n; i++) {
    struct entry *e = &all->entry[i];
    if (all->picture) picture_begin(all->picture);
    if (lockstep_run(&l, i ? &e->file : NULL, i ? &e->controller : NULL, &e->result, error) != 0) return -1;
  }
  return 0;
}

/* ---- the results --------------------------------------------------------------------- */

/* of the run without feedforward, percent */
static double error_percent(const struct entries *all, int i, int joint) {
  return 100.0 * all->entry[i].result.joint[joint].error_rad / all->entry[0].result.joint[joint].error_rad;
}

static void print_row(const struct entries *all, int i, int j) {
  const struct lockstep_joint *of = &all->entry[i].result.joint[j];
  const char *path = i ? all->entry[i].path : "none";

  printf("%-32s %-6s %8.3f mrad %7.1f %% %10.1f %% %8.2f A\n", path, tl_joint_name(&all->truth.model, j),
         1e3 * of->error_rad, error_percent(all, i, j), 100.0 * of->share, of->peak_A);
  if (of->limited)
    app_note("%s: the %s's drive was at its current limit in %lu ticks", path,
             tl_joint_name(&all->truth.model, j), of->limited);
}

static void print_table(const struct entries *all) {
  printf("%-32s %-6s %13s %9s %12s %10s\n", "feedforward of", "joint", "error", "of none's", "feedback",
         "peak");
  for (int j = 0; j < JOINTS; j++)
    for (int i = 0; i < all->n; i++) print_row(all, i, j);
}

static json_t *joint_json(const struct entries *all, int i, int j) {
  const struct lockstep_joint *of = &all->entry[i].result.joint[j];
  json_t *one = json_object();

  json_set_number(one, "error_rms_rad", of->error_rad);
  json_set_number(one, "error_percent_of_none", error_percent(all, i, j));
  json_set_number(one, "feedback_rms_Nm", of->feedback_Nm);
  json_set_number(one, "feedforward_rms_Nm", of->feedforward_Nm);
  json_set_number(one, "torque_rms_Nm", of->total_Nm);
  json_set_number(one, "feedback_share", of->share);
  json_set_number(one, "peak_current_A", of->peak_A);
  json_set_number(one, "current_limit_A", of->limit_A);
  json_set_number(one, "feedforward_peak_current_A", of->feedforward_peak_A);
  json_set_number(one, "feedforward_current_limit_A", of->feedforward_limit_A);
  json_object_set_new(one, "ticks_at_limit", json_integer((json_int_t)of->limited));
  return one;
}

static json_t *entry_json(const struct entries *all, int i) {
  json_t *one = json_object(), *told = json_object();

  json_object_set_new(one, "model", i ? json_text(all->entry[i].path) : json_null());
  json_object_set_new(one, "ticks", json_integer((json_int_t)all->entry[i].result.ticks));
  for (int j = 0; j < JOINTS; j++)
    json_object_set_new(one, tl_joint_name(&all->truth.model, j), joint_json(all, i, j));
  for (int bit = 0; bit < FEED_STATUS_BITS; bit++)
    json_object_set_new(told, feed_status_name(bit),
                        json_integer((json_int_t)all->entry[i].result.told[bit]));
  json_object_set_new(one, "status_ticks", told);
  return one;
}

static int write_report(const struct comparison *c, const struct entries *all, struct app_error *error) {
  json_t *root = json_object(), *runs = json_array();
  int result;

  json_set_text(root, "schema", "talus-feedforward/1");
  json_set_text(root, "truth", c->truth);
  json_set_text(root, "motion", c->motion);
  for (int i = 0; i < all->n; i++) json_array_append_new(runs, entry_json(all, i));
  json_object_set_new(root, "runs", runs);
  result = json_file_write(c->report, root, error);
  json_decref(root);
  return result;
}

static int write_page(const struct comparison *c, const struct entries *all, struct app_error *error) {
  struct picture_run run[1 + COMPARISON_MODELS];

  for (int i = 0; i < all->n; i++)
    run[i] = (struct picture_run){i ? all->entry[i].path : "none", &all->entry[i].result};
  return picture_write(all->picture, c->html, run, all->n, error);
}

static int run_and_write(const struct comparison *c, struct entries *all, struct app_error *error) {
  if (c->html && output_probe(c->html, error) != 0) return -1;
  all->picture = c->html ? picture_new(all->n) : NULL;
  if (c->html && !all->picture) return app_fail(error, APP_FAILED, "out of memory");
  if (run_all(c, all, error) != 0) return -1;
  if (c->report && write_report(c, all, error) != 0) return -1;
  return c->html ? write_page(c, all, error) : 0;
}

int comparison_run(const struct comparison *c, int models, char **model, struct app_error *error) {
  static struct entry entry[1 + COMPARISON_MODELS];
  static struct entries all;
  int result;

  all.entry = entry;
  all.n = 1 + models;
  for (int i = 0; i < models; i++) entry[1 + i].path = model[i];
  if (read_models(c, &all, error) != 0) return -1;
  if (trajectory_read(c->motion, &all.truth.model, NULL, &all.motion, error) != 0) return -1;
  result = run_and_write(c, &all, error);
  picture_free(all.picture);
  if (result == 0) print_table(&all);
  trajectory_free(&all.motion);
  return result;
}
