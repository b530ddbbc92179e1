/* plant_name.h: the plants' names, as model files and messages have them. */
#ifndef PLANT_NAME_H
#define PLANT_NAME_H

#include "talus/plant.h"

/* "leg", "pendulum", "slider". */
const char *plant_name(tl_plant plant);
/* 0 and the plant of that name, or -1. */
int plant_from_name(const char *name, tl_plant *plant);

#endif
