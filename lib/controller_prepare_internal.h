/* controller_prepare_internal.h: what the parts of the preparation share, inside lib/. */
#ifndef TALUS_CONTROLLER_PREPARE_INTERNAL_H
#define TALUS_CONTROLLER_PREPARE_INTERNAL_H

#include "talus/experimental/controller_prepare.h"

/* a controller that is being made: where the next curve's knots go, and what its effects need to know */
typedef struct tl_preparation {
  tl_controller_f64 *c;
  const tl_model *model;
  const tl_effect *effect;
  int effects;
  const tl_controller_settings *settings;
  tl_curve_knot_f64 *knot;
} tl_preparation;

/* Everything that effects add, after the plain model is in. *refused as in tl_controller_prepare. */
TL_CHECK tl_status tl_controller_add_effects(tl_preparation *p, int *refused);
/* Looks at all effects; the drives of `model` with what linkage errors change in their transmissions. */
TL_CHECK tl_status tl_controller_true_drives(const tl_preparation *p, const tl_model *model,
                                             tl_drive drive[TL_CONTROLLER_JOINTS], int *refused);
/* The most that the curves of effects at a joint can add to its motor torque's error [N m], in 16 points a step. */
double tl_controller_curves_error(const tl_preparation *p, const tl_controller_f64 *c, int joint);

#endif
