/* experimental.h: what may still change between versions: effects, simulation, the bench's twin, rows for a fit.
 *
 *     #include <talus/talus.h>
 *     #include <talus/experimental.h>
 *     puts(tl_effect_find("backlash")->name); // prints backlash
 *
 * talus.h is what a controller or a program links, and keeps its promises from version to version.
 */
#ifndef TALUS_EXPERIMENTAL_H
#define TALUS_EXPERIMENTAL_H

#include "talus/experimental/controller_prepare.h"
#include "talus/experimental/effect.h"
#include "talus/experimental/excitation.h"
#include "talus/experimental/hysteresis.h"
#include "talus/experimental/regression.h"
#include "talus/experimental/simulate.h"
#include "talus/experimental/twin.h"

#endif
