/* report.c: see report.h. */
#include "report.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/json_file.h"

#define SLOW_WINDOW 1.5   /* a window of so many periods of the low-pass smears what is scored */
#define SMALL 0.1         /* of what was found: a figure that says little beside what is hidden */
#define FIXED_WITHIN 0.01 /* of an inertia: a larger standard deviation is said */
#define MANY_TIMES 10.0   /* what was found: farther off, a figure says no more */
#define ROUNDING 1e-9     /* of the parameter's size: so near to 0 is 0 */
#define POORLY_KNOWN 0.5  /* of the parameter's size: a standard deviation to warn of */
#define IN_DIRECTION 1e-3 /* share of a null direction from which on a parameter belongs to it */

/* ---- JSON ------------------------------------------------------------------- */

static json_t *parameters_json(const struct report_input *in) {
  const tl_problem *p = &in->fit->problem;
  const tl_identify_result *r = &in->fit->result;
  const tl_parameter *table = tl_parameters(&p->model, &(int){0});
  json_t *all = json_object();

  for (int i = 0; i < p->parameters; i++) {
    json_t *one = json_object();
    json_set_number(one, "prior", p->prior[i]);
    json_set_number(one, "value", r->value[i]);
    json_set_number(one, "sigma", r->sigma[i]);
    json_set_number(one, "systematic", r->identifiable[i] ? r->systematic[i] : (double)NAN);
    json_object_set_new(one, "hidden_by_noise", json_boolean(r->hidden[i]));
    json_object_set_new(one, "identifiable", json_boolean(r->identifiable[i]));
    json_object_set_new(one, "at_bound", json_boolean(r->at_bound[i]));
    json_object_set_new(all, table[i].name, one);
  }
  return all;
}

static json_t *base_json(const struct report_input *in) {
  const tl_problem *p = &in->fit->problem;
  json_t *all = json_object();

  for (int i = 0; i < p->bases; i++) {
    json_t *one = json_object();
    json_set_number(one, "value", in->fit->result.base[i]);
    json_set_number(one, "sigma", in->fit->result.base_sigma[i]);
    json_set_number(one, "systematic", in->fit->result.base_systematic[i]);
    json_object_set_new(all, tl_base_name(&p->model, i), one);
  }
  return all;
}

static json_t *null_space_json(const struct report_input *in) {
  const tl_problem *p = &in->fit->problem;
  const tl_identify_result *r = &in->fit->result;
  const tl_parameter *table = tl_parameters(&p->model, &(int){0});
  json_t *all = json_array();

  for (int k = 0; k < r->null_count; k++) {
    json_t *one = json_object();
    for (int i = 0; i < p->parameters; i++)
      if (fabs(r->null_direction[k][i]) > 1e-6) json_set_number(one, table[i].name, r->null_direction[k][i]);
    json_array_append_new(all, one);
  }
  return all;
}

static json_t *error_json(const struct report_input *in) {
  const tl_model *m = &in->prior->model;
  json_t *all = json_object();

  for (int j = 0; j < tl_joint_count(m); j++) {
    const struct fit_error *e = &in->fit->error[j];
    json_t *one = json_object();
    json_set_text(one, "unit", scored_unit(m));
    json_set_number(one, "nominal_rms", scored_rms(&e->nominal));
    json_set_number(one, "identified_rms", scored_rms(&e->identified));
    json_set_number(one, "relative_percent", scored_relative_percent(&e->identified));
    json_set_number(one, "measured_rms", scored_measured_rms(&e->identified));
    json_set_number(one, "reversal_rms", scored_reversal_rms(&e->identified));
    json_object_set_new(one, "samples", json_integer((json_int_t)e->identified.rows));
    json_object_set_new(one, "samples_left_out", json_integer((json_int_t)e->identified.left_out));
    json_object_set_new(all, tl_joint_name(m, j), one);
  }
  return all;
}

static json_t *recordings_json(const struct report_input *in) {
  const tl_model *m = &in->prior->model;
  json_t *all = json_array();

  for (int i = 0; i < in->recordings; i++) {
    const tl_regression *r = stream_regression(in->stream[i]);
    json_t *one = json_object();
    json_set_text(one, "file", in->path[i]);
    for (int j = 0; j < tl_joint_count(m); j++) {
      const tl_sensing *s = &r->sensing[j];
      json_t *sensing = json_object();
      json_object_set_new(sensing, "window_order", json_integer(s->window.order));
      json_set_number(sensing, "window_s", s->window.length_s);
      json_set_number(sensing, "noise", s->noise);
      json_set_number(sensing, "resolution", s->step);
      json_set_number(sensing, "standstill", s->standstill);
      json_object_set_new(one, tl_joint_name(m, j), sensing);
    }
    json_array_append_new(all, one);
  }
  return all;
}

int report_write_json(const char *path, const struct report_input *in, struct app_error *error) {
  const struct fit *fit = in->fit;
  json_t *root = json_object();
  int result;

  json_set_text(root, "schema", "talus-identify/1");
  json_object_set_new(root, "seed", json_integer((json_int_t)in->seed));
  json_object_set_new(root, "evaluations", json_integer((json_int_t)fit->evaluations));
  json_set_number(root, "cost", fit->result.cost);
  json_set_number(root, "least_squares_cost", fit->result.least_squares_cost);
  json_object_set_new(root, "parameters", parameters_json(in));
  json_object_set_new(root, "base_parameters", base_json(in));
  json_object_set_new(root, "null_space", null_space_json(in));
  json_set_number(root, "condition_number", fit->result.condition_number);
  json_object_set_new(root, "error", error_json(in));
  json_object_set_new(root, "recordings", recordings_json(in));
  result = json_file_write(path, root, error);
  json_decref(root);
  return result;
}

/* ---- words ------------------------------------------------------------------- */

static void say_windows(const struct report_input *in) {
  const tl_model *m = &in->prior->model;

  for (int i = 0; i < in->recordings; i++)
    for (int j = 0; j < tl_joint_count(m); j++) {
      const tl_sensing *s = &stream_regression(in->stream[i])->sensing[j];
      fprintf(stderr, "%s: %s: window of order %d over %.3g s, encoder noise %.2g, standstill below %.2g\n",
              in->path[i], tl_joint_name(m, j), s->window.order, s->window.length_s, s->noise, s->standstill);
    }
}

/* the default window has a least number of samples; where these span more than the scored band allows,
 * what it smears is no noise and no standard deviation counts it */
static void warn_of_slow_sampling(const struct report_input *in) {
  for (int i = 0; i < in->recordings; i++) {
    const tl_regression *r = stream_regression(in->stream[i]);
    const tl_sensing *s = &r->sensing[0];
    if (s->across || s->window.length_s * r->score.lowpass_hz < SLOW_WINDOW) continue;
    app_note(
        "%s: samples %.3g ms apart are slow for a low-pass of %.3g Hz: friction and inertia may be off by "
        "more than their standard deviations",
        in->path[i], 1e3 * r->step_s, r->score.lowpass_hz);
  }
}

static void say_parameters(const struct report_input *in) {
  const tl_problem *p = &in->fit->problem;
  const tl_identify_result *r = &in->fit->result;
  const tl_parameter *table = tl_parameters(&p->model, &(int){0});

  fprintf(stderr, "%-28s %12s %12s %10s\n", "parameter", "given", "identified", "+-");
  for (int i = 0; i < p->parameters; i++) {
    fprintf(stderr, "%-28s %12.5g %12.5g ", table[i].name, p->prior[i], r->value[i]);
    if (p->settings.fixed[i])
      fprintf(stderr, "%10s\n", "fixed");
    else if (!r->identifiable[i])
      fprintf(stderr, "%10s\n", "(*)");
    else if (r->hidden[i])
      fprintf(stderr, "%10s%s\n", "unknown", r->at_bound[i] ? "  at its bound" : "");
    else
      fprintf(stderr, "%10.2g%s\n", r->sigma[i], r->at_bound[i] ? "  at its bound" : "");
  }
}

/* the parameters of a null direction, a bit each */
static unsigned members(const double *direction) {
  unsigned set = 0;

  for (int i = 0; i < TL_MAX_PARAMETERS; i++)
    if (fabs(direction[i]) > IN_DIRECTION) set |= 1u << i;
  return set;
}

static void list_names(const tl_parameter *table, unsigned set, char *text, size_t size) {
  text[0] = '\0';
  for (int i = 0; i < TL_MAX_PARAMETERS; i++) {
    size_t used = strlen(text);
    if (set >> i & 1u) snprintf(text + used, size - used, "%s%s", used ? ", " : "", table[i].name);
  }
}

int report_null_text(const struct report_input *in, int direction, unsigned *told, char *text, size_t size) {
  const tl_parameter *table = tl_parameters(&in->fit->problem.model, &(int){0});
  const unsigned set = members(in->fit->result.null_direction[direction]);
  char names[400];

  if ((set & ~*told) == 0) return 0;
  *told |= set;
  list_names(table, set, names, sizeof names);
  if (set & (set - 1))
    snprintf(text, size,
             "these recordings see only combinations of %s: of all values that predict the same, those "
             "nearest to the given ones are kept",
             names);
  else
    snprintf(text, size, "%s is not excited by these recordings: the given value is kept", names);
  return 1;
}

int report_inertia_text(const struct report_input *in, int parameter, char *text, size_t size) {
  const tl_identify_result *r = &in->fit->result;
  const tl_parameter *p = &tl_parameters(&in->fit->problem.model, &(int){0})[parameter];
  double value = fabs(r->value[parameter]), systematic = r->systematic[parameter];
  char moved[40];

  if (!r->identifiable[parameter]) return 0;
  if (r->hidden[parameter] && systematic <= SMALL * value) {
    snprintf(text, size,
             "these recordings do not fix %s: resolution, noise and sampling of the angles hide some of it, and it "
             "may be any amount too small",
             p->name);
    return 1;
  }
  if (r->hidden[parameter]) {
    if (value > 0.0 && systematic <= MANY_TIMES * value)
      snprintf(moved, sizeof moved, "%.0f %% of", 100.0 * systematic / value);
    else
      snprintf(moved, sizeof moved, "more than %.0f times", MANY_TIMES);
    snprintf(
        text, size,
        "these recordings do not fix %s: resolution, noise and sampling of the angles move it by %s "
        "what was found, and it may be any amount too small",
        p->name, moved);
    return 1;
  }
  if (!p->positive || !(r->sigma[parameter] > FIXED_WITHIN * value)) return 0;
  snprintf(text, size,
           "these recordings fix %s within %.1f %% only (one standard deviation); resolution, noise and "
           "sampling of "
           "the angles alone move it by %.1f %%",
           p->name, 100.0 * r->sigma[parameter] / value, 100.0 * systematic / value);
  return 1;
}

void report_warn(const struct report_input *in) {
  const tl_problem *p = &in->fit->problem;
  const tl_identify_result *r = &in->fit->result;
  const tl_parameter *table = tl_parameters(&p->model, &(int){0});
  char text[REPORT_TEXT];
  unsigned told = 0;

  warn_of_slow_sampling(in);
  for (int k = 0; k < r->null_count; k++)
    if (report_null_text(in, k, &told, text, sizeof text)) app_note("not identifiable (*): %s", text);
  for (int i = 0; i < p->parameters; i++) {
    if (r->identifiable[i] && r->at_bound[i])
      app_note("%s ends at its bound, %.3g", table[i].name,
               fabs(r->value[i]) > ROUNDING * p->scale[i] ? r->value[i] : 0.0);
    else if (r->identifiable[i] && r->sigma[i] > POORLY_KNOWN * p->scale[i])
      app_note("%s is hardly excited: its standard deviation is %.2g on a value of %.3g", table[i].name,
               r->sigma[i], r->value[i]);
    if (report_inertia_text(in, i, text, sizeof text)) app_note("%s", text);
  }
  if (in->fit->few_blocks) app_note("too little data for standard deviations");
}

static void say_certificate(const struct fit *fit) {
  double excess = fit->result.cost - fit->result.least_squares_cost;
  double relative = fit->result.least_squares_cost > 0.0 ? excess / fit->result.least_squares_cost : 0.0;

  fprintf(stderr,
          "swarm: %llu evaluations; cost %.3g above least squares (relative), condition number %.3g\n",
          (unsigned long long)fit->evaluations, relative, fit->result.condition_number);
  if (relative > 1e-6)
    app_note(
        "the swarm's optimum is not that of least squares: a bound is active, or more particles are needed");
}

static void say_error(const struct report_input *in, int joint) {
  const tl_model *m = &in->prior->model;
  const struct scored *nominal = &in->fit->error[joint].nominal, *e = &in->fit->error[joint].identified;
  const char *name = tl_joint_name(m, joint), *unit = scored_unit(m);

  if (e->rows == 0)
    fprintf(stderr, "%s: no samples in motion, nothing to score; %zu near standstill left out\n", name,
            e->left_out);
  else
    fprintf(stderr,
            "%s: error %.1f %% of the measured %s (RMS %.4g of %.4g %s, as given %.4g), %zu samples, "
            "%zu near standstill left out\n",
            name, scored_relative_percent(e), scored_quantity(m), scored_rms(e), scored_measured_rms(e), unit,
            scored_rms(nominal), e->rows, e->left_out);
}

void report_say(const struct report_input *in) {
  const tl_model *m = &in->prior->model;

  say_windows(in);
  say_parameters(in);
  report_warn(in);
  say_certificate(in->fit);
  for (int j = 0; j < tl_joint_count(m); j++) say_error(in, j);
}
