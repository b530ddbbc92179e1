/* header.h: a prepared controller as a C header, in double, float and fixed point. */
#ifndef EXPORT_HEADER_H
#define EXPORT_HEADER_H

#include "common/output.h"
#include "controller/controller_options.h"
#include "talus/experimental/controller_prepare.h"

#define HEADER_NAME_MAX 40

struct header_parts {
  char name[HEADER_NAME_MAX + 1];
  const char *path; /* of the model file */
  const tl_model *model;
  struct controller made;
  tl_controller_bound bound;
  /* made by header_write */
  tl_controller_f32 f32;
  tl_controller_q31 q31;
  tl_curve_knot_f32 knot_f32[TL_CONTROLLER_KNOTS];
  tl_curve_knot_q31 knot_q31[TL_CONTROLLER_KNOTS];
};

/* The last part of a path without its extension, as a name in C. 0, or -1 where it is none. */
int header_name(const char *path, char *name, size_t size);
/* Where fixed point cannot hold the model the header says so in that kind's place. */
void header_write(struct output *out, struct header_parts *parts);

#endif
