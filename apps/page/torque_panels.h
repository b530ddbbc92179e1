/* torque_panels.h: torque over time: measured, what models predict, and what is left; in bounded memory.
 *
 *     static const struct torque_line line[] = {{"predicted", "identified", "residual", 0}};
 *     struct torque_panels *panels = torque_panels_new(line, 1, joints);
 *     for each instant: torque_panels_add(panels, joint, t_s, measured, &predicted, scored);
 *     torque_panels_chart(panels, joint, page, "knee", "torque", "Nm");
 *     torque_panels_free(panels);
 */
#ifndef TORQUE_PANELS_H
#define TORQUE_PANELS_H

#include <stddef.h>

#include "page.h"

#define TORQUE_LINES 2 /* predictions at most */

/* One prediction: its name, its colour and its residual's (page.h), and whether it lies beneath what was measured. */
struct torque_line {
  const char *name, *role, *residual_role;
  int beneath;
};

struct torque_panels;

/* NULL when out of memory; the lines are kept by reference. */
struct torque_panels *torque_panels_new(const struct torque_line *line, int lines, size_t panels);
/* Nullable: panels. */
void torque_panels_free(struct torque_panels *panels);

/* An instant of one panel, in order of time; residuals show only where it is scored. */
void torque_panels_add(struct torque_panels *panels, size_t panel, double t_s, double measured,
                       const double *predicted, int scored);
void torque_panels_chart(const struct torque_panels *panels, size_t panel, struct page *page,
                         const char *title, const char *quantity, const char *unit);

#endif
