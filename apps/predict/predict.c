/* predict.c: see predict.h. */
#include "predict.h"

#include <string.h>

#define CHUNK 1024

struct predicting {
  struct output *out;
  struct recording *recording;
  int joints;
  double base[TL_MAX_BASE];
  size_t next; /* row to write next */
  int known;   /* 1: `last` holds a prediction */
  double last_s, last[TL_MAX_JOINTS];
};

/* the names of the columns; with a sensor at the output, that column is what is predicted */
static void write_header(struct output *out, const tl_model *model, const tl_layout *layout) {
  const tl_facts *f = tl_plant_facts(model->plant);

  output_text(out, "time_s");
  for (int j = 0; j < f->joints; j++)
    output_printf(out, ",%s",
                  layout->load == TL_NO_CHANNEL ? f->prediction[j] : tl_channel_name(layout->load));
  output_text(out, "\n");
}

/* rows [next, end) have no prediction of their own: each holds the nearer of the last one and
 * the coming one (Nullable: coming) */
static int hold(struct predicting *p, size_t end, double coming_s, const double *coming,
                struct app_error *error) {
  double t_s[CHUNK], *column[TL_CHANNEL_COUNT] = {NULL};
  size_t n;

  column[TL_CHANNEL_TIME] = t_s;
  for (; p->next < end; p->next += n) {
    n = end - p->next < CHUNK ? end - p->next : CHUNK;
    if (recording_read(p->recording, p->next, n, column, NULL, error) != 0) return -1;
    for (size_t i = 0; i < n; i++) {
      int nearer_last = p->known && (!coming || t_s[i] - p->last_s <= coming_s - t_s[i]);
      output_row(p->out, t_s[i], nearer_last ? p->last : coming, (size_t)p->joints);
    }
  }
  return 0;
}

static int write_part(const struct stream_part *part, void *context, struct app_error *error) {
  struct predicting *p = context;

  for (size_t row = part->begin; row < part->end; row++) {
    size_t i = row - part->first;
    double now[TL_MAX_JOINTS];

    for (int j = 0; j < p->joints; j++) now[j] = tl_regression_predict(part->space, j, p->base, i);
    if (p->next < row && hold(p, row, part->t_s[i], now, error) != 0) return -1;
    output_row(p->out, part->t_s[i], now, (size_t)p->joints);
    memcpy(p->last, now, sizeof now);
    p->last_s = part->t_s[i];
    p->known = 1;
    p->next = row + 1;
  }
  return 0;
}

int predict_write(struct output *out, struct recording *recording, struct stream *stream,
                  const tl_model *model, struct app_error *error) {
  struct predicting p = {.out = out, .recording = recording, .joints = tl_joint_count(model)};

  tl_base_values(model, p.base);
  write_header(out, model, &stream_regression(stream)->layout);
  stream_set_task(stream, "predicting");
  if (stream_motion(stream, write_part, &p, error) != 0) return -1;
  return hold(&p, recording_rows(recording), 0.0, NULL, error);
}
