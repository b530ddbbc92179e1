/* plant_name.c: the plants' names. */
#include "plant_name.h"

#include <string.h>

static const struct {
  tl_plant plant;
  const char *name;
} plants[] = {{TL_PLANT_LEG, "leg"}, {TL_PLANT_PENDULUM, "pendulum"}, {TL_PLANT_SLIDER, "slider"}};

enum { PLANTS = sizeof plants / sizeof plants[0] };

const char *plant_name(tl_plant plant) {
  for (int i = 0; i < PLANTS; i++)
    if (plants[i].plant == plant) return plants[i].name;
  return "unknown plant";
}

int plant_from_name(const char *name, tl_plant *plant) {
  for (int i = 0; i < PLANTS; i++)
    if (strcmp(plants[i].name, name) == 0) {
      *plant = plants[i].plant;
      return 0;
    }
  return -1;
}
