/* kinematics_stops.h: where a joint stands still; internal to lib/. */
#ifndef TALUS_KINEMATICS_STOPS_H
#define TALUS_KINEMATICS_STOPS_H

#include "talus/kinematics.h"
#include "talus/signal.h"

/* Stops of a joint from its angle (or any quantity proportional to it near the stop) and its quick velocity; writes at most n,
 * returns how many. Nullable: angle (velocity was recorded, then a stop begins at its last moving row). */
size_t tl_find_stops(const double *t_s, const double *angle, const double *velocity, size_t n,
                     double standstill, tl_stop *stop);

/* Direction of friction at every row: the sign of the slip phase's velocity (the one its stops were found by) while
 * sliding, a ramp in time from the sign before to the sign after through a stop. */
void tl_slip_through_stops(const double *t_s, const double *velocity, size_t n, const tl_stop *stop,
                           size_t stops, double *slip);

/* 1: the stop is bridged (tl_bridge_stops); a longer one is a hold. */
int tl_is_short_stop(const tl_stop *stop, const double *t_s);

#endif
