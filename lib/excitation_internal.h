/* excitation_internal.h: what the two halves of talus/experimental/excitation.h share. */
#ifndef TALUS_EXCITATION_INTERNAL_H
#define TALUS_EXCITATION_INTERNAL_H

#include "talus/experimental/excitation.h"

/* One joint's excursion from its offset times `factor`. */
void tl_excitation_scale(tl_excitation *e, int joint, double factor);

/* All peaks of tl_excitation_peaks, their limits not yet filled in. Nullable: m (then torque is 0). */
void tl_excitation_find_peaks(const tl_model *m, const tl_excitation *e, tl_peak peak[TL_MAX_PEAKS]);

#endif
