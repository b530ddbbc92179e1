/* live.h: the twin on a CAN bus, in real time.
 *
 * Each tick of the control has an absolute deadline. At it the twin takes what has come over the
 * bus, simulates up to its next sample, and sends that as the drives would (models/leg.dbc). A
 * tick that comes late is simulated all the same: no sample is left out, and the counters in the
 * frames number the ticks.
 */
#ifndef LIVE_H
#define LIVE_H

#include "common/output.h"
#include "recording/recording_writer.h"
#include "twin.h"

/* The bench's sensors and rates as the bus has them. 0, or -1 with status 2 when the model says
 * nothing about the bus or something else was asked for. */
int live_prepare(struct twin *t, struct app_error *error);
/* All samples, over the bus and into the files; ends early on SIGINT and SIGTERM. Nullable: motion. */
int live_run(struct twin *t, tl_twin *bench, struct recording_writer *writer, struct output *motion,
             struct app_error *error);

#endif
