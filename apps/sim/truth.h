/* truth.h: what a run of the twin knows and a recording does not say. */
#ifndef TRUTH_H
#define TRUTH_H

#include "common/output.h"
#include "twin.h"

/* The true motion as CSV: for each joint its reference, position, velocity, acceleration, the torque
 * of tl_inverse and the friction's share of its Coulomb level; first the header, then a row a sample. */
void truth_motion_header(struct output *out, const tl_model *m);
void truth_motion_row(struct output *out, const tl_twin *b, double t_s);

/* Parameters, sensors and excitation as JSON, to the path that was asked for. 0, or -1. */
int truth_write(const struct twin *t, const tl_twin *b, struct app_error *error);

#endif
