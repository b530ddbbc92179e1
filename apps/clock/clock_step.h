/* clock_step.h: was the clock set between two readings of it? What talus-acquire info tells of and what the export joins is the same.
 *
 *     const double apart = clock_drift_most_ns(passed_ns, width_a_ns + width_b_ns);
 *     if (fabs(change_of_real_less_mono_ns) > apart) ... // the clock was set by that
 */
#ifndef CLOCK_STEP_H
#define CLOCK_STEP_H

/* By how much realtime less monotonic may change from one reading to another while nobody sets the clock: `passed_ns`
 * lie between the two on the monotonic clock, and `widths_ns` is how long they took together. */
double clock_drift_most_ns(double passed_ns, double widths_ns);

/* The largest such change for each nanosecond that passes. */
double clock_most_drift(void);

/* Two readings within less than this of a straight line are on it. */
double clock_read_ns(void);

#endif
