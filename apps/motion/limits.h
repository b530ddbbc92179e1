/* limits.h: what joints can do, as --limits gives it to every program.
 *
 *     tl_limits limit[TL_MAX_JOINTS] = {tl_limits_none(), tl_limits_none()};
 *     limits_read("knee.position=-0.9:0.1,ankle.speed=4", &model, limit, &error);
 */
#ifndef LIMITS_H
#define LIMITS_H

#include "common/error.h"
#include "talus/experimental/excitation.h"

/* A list with commas of JOINT.position=LOW:HIGH and JOINT.speed=, .acceleration=, .torque= (all above 0), joints by
 * the plant's names, units of plant.h. What is not named stays as it is; where something is wrong nothing is set,
 * and the result is -1 with status 2. */
int limits_read(const char *text, const tl_model *model, tl_limits limit[TL_MAX_JOINTS],
                struct app_error *error);

#endif
