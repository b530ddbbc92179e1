/* reference.h: the bench follows a trajectory from a file.
 *
 * The bench follows an excitation; here that is a short series, laid anew for each sample through the trajectory's
 * position, speed and acceleration amid the ticks that come up to it.
 */
#ifndef REFERENCE_H
#define REFERENCE_H

#include "motion/trajectory.h"
#include "talus/experimental/twin.h"

/* The excitation that rests where the trajectory begins. */
void reference_rest(const struct trajectory *t, tl_excitation *e);
/* For the ticks up to the bench's next sample. */
void reference_lay(const struct trajectory *t, const tl_twin *b, tl_excitation *e);
/* Every limit that a row breaks, as tl_excitation_check: joint after joint, their number. */
int reference_check(const tl_model *m, const tl_limits limits[TL_MAX_JOINTS], const struct trajectory *t,
                    tl_peak peak[TL_MAX_PEAKS]);

#endif
