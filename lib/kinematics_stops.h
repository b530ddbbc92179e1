/* kinematics_stops.h: where a joint stands still; internal to lib/. */
#ifndef TALUS_KINEMATICS_STOPS_H
#define TALUS_KINEMATICS_STOPS_H

#include "talus/kinematics.h"
#include "talus/signal.h"

/* Stops of a joint from its angle (or any quantity proportional to it near the stop) and its quick velocity; writes at most n,
 * returns how many. Nullable: angle (velocity was recorded, then a stop begins at its last moving row). */
size_t tl_find_stops(const double *t_s, const double *angle, const double *velocity, size_t n,
                     double standstill, tl_stop *stop);

/* Direction of friction at every row: the sign of the piece's velocity (the one its stops were found by) while
 * sliding, a ramp in time from the sign before to the sign after through a stop. */
void tl_slip_through_stops(const double *t_s, const double *velocity, size_t n, const tl_stop *stop,
                           size_t stops, double *slip);

/* 1: the stop is bridged (tl_bridge_stops); a longer one is a hold. */
int tl_is_short_stop(const tl_stop *stop, const double *t_s);

/* Which ends of a piece of motion stand beside a stop. */
enum { TL_FROM_REST = 1, TL_TO_REST = 2 };

/* The ends of the piece between two stops (NULL: the recording's begin or end) whose rows have windows of their own:
 * those beside a stop that is bridged. */
int tl_edges_of_piece(const tl_stop *before, const tl_stop *after, const double *t_s);

/* Motion of n rows between two stops by their own windows, of a lower order where they are few. The windows of the
 * first and last row stand to one side: at the `edges` they have one order less (from rest) or two (to rest) over
 * two thirds of the length, which overshoots less there.
 * Nullable: q. TL_ERR_TOO_SHORT with fewer than 4 rows. */
TL_CHECK tl_status tl_reconstruct_piece(const tl_window *window, const double *t_s, const double *x, size_t n,
                                        int edges, double *q, double *v, double *a, double *work,
                                        size_t work_n);

#endif
