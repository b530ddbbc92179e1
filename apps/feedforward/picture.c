/* picture.c: see picture.h. */
#include "picture.h"

#include <stdio.h>
#include <stdlib.h>

#include "page/page.h"

enum { JOINTS = TL_CONTROLLER_JOINTS, RUNS = PICTURE_RUNS, TEXT = 160 };
enum { DESIRED, MEASURED, FEEDFORWARD, FEEDBACK, INERTIA, GRAVITY, FRICTION, EFFECTS, LINES };

static const char *const joint_name[JOINTS] = {"knee", "ankle"};

/* the last run's lines of one joint, and every run's error */
struct picture {
  int runs, now; /* now: the run that is on, from 0 */
  struct envelope line[JOINTS][LINES];
  struct envelope error[][JOINTS];
};

struct picture *picture_new(int runs) {
  struct picture *p = malloc(sizeof *p + (size_t)runs * sizeof p->error[0]);

  if (!p) return NULL;
  p->runs = runs;
  p->now = -1;
  for (int i = 0; i < runs; i++)
    for (int j = 0; j < JOINTS; j++) envelope_init(&p->error[i][j]);
  return p;
}

void picture_free(struct picture *picture) {
  free(picture);
}

void picture_begin(struct picture *picture) {
  picture->now++;
  for (int j = 0; j < JOINTS; j++)
    for (int k = 0; k < LINES; k++) envelope_init(&picture->line[j][k]);
}

void picture_see(void *context, const struct lockstep_instant *at) {
  struct picture *p = context;

  for (int j = 0; j < JOINTS; j++) {
    const struct lockstep_joint_instant *one = &at->joint[j];
    const double value[LINES] = {one->desired_rad, one->measured_rad, one->feedforward_Nm, one->feedback_Nm,
                                 one->inertia_Nm,  one->gravity_Nm,   one->friction_Nm,    one->effects_Nm};

    for (int k = 0; k < LINES; k++) envelope_add(&p->line[j][k], at->t_s, value[k]);
    envelope_add(&p->error[p->now][j], at->t_s, 1e3 * one->error_rad);
  }
}

/* ---- the page ------------------------------------------------------------------------ */

static double percent(const struct picture_run *run, int i, int joint) {
  return 100.0 * run[i].result->joint[joint].error_rad / run[0].result->joint[joint].error_rad;
}

static void put_figures(struct page *page, const struct picture_run *run, int runs) {
  static const char *const columns[] = {"feedforward of", "joint",    "error [mrad]", "of none's [%]",
                                        "feedback [%]",   "peak [A]", "limit [A]"};
  char text[5][32];

  page_table(page, "RMS over the motion", columns, 7);
  for (int j = 0; j < JOINTS; j++)
    for (int i = 0; i < runs; i++) {
      const struct lockstep_joint *of = &run[i].result->joint[j];
      const double value[5] = {1e3 * of->error_rad, percent(run, i, j), 100.0 * of->share, of->peak_A,
                               of->limit_A};
      const char *const cells[] = {run[i].name, joint_name[j], text[0], text[1], text[2], text[3], text[4]};

      for (int k = 0; k < 5; k++) snprintf(text[k], sizeof text[k], "%.4g", value[k]);
      page_table_row(page, cells);
    }
}

/* in how many ticks each bit of the status stood, with feedforward */
static void put_status(struct page *page, const struct picture_run *run, int runs) {
  const char *cells[RUNS] = {"limit or fault"};
  char text[RUNS][24];

  for (int i = 1; i < runs; i++) cells[i] = run[i].name;
  page_table(page, "Ticks in which torque was held back or taken away, before and after the motion too",
             cells, (size_t)runs);
  for (int bit = 0; bit < FEED_STATUS_BITS; bit++) {
    cells[0] = feed_status_name(bit);
    for (int i = 1; i < runs; i++) {
      snprintf(text[i], sizeof text[i], "%lu", run[i].result->told[bit]);
      cells[i] = text[i];
    }
    page_table_row(page, cells);
  }
}

/* angles of the last run, and below them the errors of all */
static void put_angles(struct page *page, const struct picture *p, const struct picture_run *run, int joint) {
  static const char *const role[] = {"measured", "nominal", "identified", "extended", "noise", "residual"};
  char title[TEXT];
  json_t *angle, *error;

  snprintf(title, sizeof title, "%s: angle with %.100s", joint_name[joint], run[p->runs - 1].name);
  angle = page_chart(page, title, "time [s]", "angle [rad]");
  page_envelope(angle, "measured", "measured", &p->line[joint][MEASURED]);
  page_envelope(angle, "desired", "predicted", &p->line[joint][DESIRED]);
  error = page_chart_below(page, angle, "error [mrad]");
  for (int i = 0; i < p->runs; i++)
    page_envelope(error, run[i].name, role[i < 6 ? i : 5], &p->error[i][joint]);
}

/* what the motor gave in the last run, and below it what the model asked for at the joint */
static void put_torques(struct page *page, const struct picture *p, const struct picture_run *run,
                        int joint) {
  static const struct {
    int line;
    const char *name, *role;
  } part[] = {{INERTIA, "inertia", "identified"},
              {GRAVITY, "gravity", "nominal"},
              {FRICTION, "friction", "residual"},
              {EFFECTS, "effects", "noise"}};
  char title[TEXT];
  json_t *torque, *parts;

  snprintf(title, sizeof title, "%s: torque with %.100s", joint_name[joint], run[p->runs - 1].name);
  torque = page_chart(page, title, "time [s]", "motor [Nm]");
  page_envelope(torque, "feedforward", "predicted", &p->line[joint][FEEDFORWARD]);
  page_envelope(torque, "feedback", "residual", &p->line[joint][FEEDBACK]);
  parts = page_chart_below(page, torque, "joint [Nm]");
  for (size_t k = 0; k < sizeof part / sizeof part[0]; k++)
    page_envelope(parts, part[k].name, part[k].role, &p->line[joint][part[k].line]);
}

int picture_write(const struct picture *picture, const char *path, const struct picture_run *run, int runs,
                  struct app_error *error) {
  const int last = runs - 1;
  char sentence[2 * TEXT];
  struct page *page;
  int result;

  snprintf(sentence, sizeof sentence,
           "With the feedforward of %.100s %.1f %% of the knee's and %.1f %% of the ankle's tracking error "
           "without are left.",
           run[last].name, percent(run, last, 0), percent(run, last, 1));
  page = page_new("Feedforward", sentence);
  if (!page) return app_fail(error, APP_FAILED, "out of memory");
  put_figures(page, run, runs);
  for (int j = 0; j < JOINTS; j++) {
    put_angles(page, picture, run, j);
    put_torques(page, picture, run, j);
  }
  put_status(page, run, runs);
  result = page_write(page, path, error);
  page_free(page);
  return result;
}
