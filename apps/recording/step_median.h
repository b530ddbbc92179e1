/* step_median.h: the median of any number of time steps, in bounded memory.
 *
 *     struct step_median *median = step_median_new();
 *     for each step: step_median_add(median, step_s);
 *     double step_s = step_median_value(median);
 *     step_median_free(median);
 *
 * Up to STEP_MEDIAN_ROOM steps it is the median of all of them; beyond, that of
 * every second, fourth, ... step, evenly over the whole recording and always the
 * same ones.
 */
#ifndef STEP_MEDIAN_H
#define STEP_MEDIAN_H

#define STEP_MEDIAN_ROOM 131072 /* steps kept, a power of two */

struct step_median;

/* NULL when out of memory. Owned by the caller. */
struct step_median *step_median_new(void);
/* Nullable: median. */
void step_median_free(struct step_median *median);
void step_median_add(struct step_median *median, double step);
/* The median, for an even number the mean of the middle two; 0 when there is none.
 * Reorders what is kept: no step may be added afterwards. */
double step_median_value(struct step_median *median);

#endif
