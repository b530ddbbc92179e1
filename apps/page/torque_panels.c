/* torque_panels.c: see torque_panels.h. */
#include "torque_panels.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define TEXT 48

struct panel {
  struct envelope measured, predicted[TORQUE_LINES], residual[TORQUE_LINES];
};

struct torque_panels {
  const struct torque_line *line;
  int lines;
  struct panel panel[];
};

struct torque_panels *torque_panels_new(const struct torque_line *line, int lines, size_t panels) {
  struct torque_panels *p = malloc(sizeof *p + panels * sizeof p->panel[0]);

  if (!p) return NULL;
  p->line = line;
  p->lines = lines;
  for (size_t i = 0; i < panels; i++) {
    envelope_init(&p->panel[i].measured);
    for (int k = 0; k < lines; k++) {
      envelope_init(&p->panel[i].predicted[k]);
      envelope_init(&p->panel[i].residual[k]);
    }
  }
  return p;
}

void torque_panels_free(struct torque_panels *panels) {
  free(panels);
}

void torque_panels_add(struct torque_panels *panels, size_t panel, double t_s, double measured,
                       const double *predicted, int scored) {
  struct panel *p = &panels->panel[panel];

  envelope_add(&p->measured, t_s, measured);
  for (int k = 0; k < panels->lines; k++) {
    envelope_add(&p->predicted[k], t_s, predicted[k]);
    envelope_add(&p->residual[k], t_s, scored ? measured - predicted[k] : (double)NAN);
  }
}

static void predictions(const struct torque_panels *panels, const struct panel *p, json_t *chart,
                        int beneath) {
  for (int k = 0; k < panels->lines; k++) {
    const struct torque_line *line = &panels->line[k];
    if (line->beneath == beneath) page_envelope(chart, line->name, line->role, &p->predicted[k]);
  }
}

void torque_panels_chart(const struct torque_panels *panels, size_t panel, struct page *page,
                         const char *title, const char *quantity, const char *unit) {
  const struct panel *p = &panels->panel[panel];
  char axis[TEXT];
  json_t *torque, *residual;

  snprintf(axis, sizeof axis, "%s [%s]", quantity, unit);
  torque = page_chart(page, title, "time [s]", axis);
  predictions(panels, p, torque, 1);
  page_envelope(torque, "measured", "measured", &p->measured);
  predictions(panels, p, torque, 0);
  snprintf(axis, sizeof axis, "residual [%s]", unit);
  residual = page_chart_below(page, torque, axis);
  for (int k = 0; k < panels->lines; k++)
    page_envelope(residual, panels->line[k].name, panels->line[k].residual_role, &p->residual[k]);
}
