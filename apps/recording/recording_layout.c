/* recording_layout.c: the columns that a plant's recording needs. */
#include "recording_layout.h"

#include <stdio.h>

int layout_init(struct layout *layout, const char *path, tl_plant plant, struct app_error *error) {
  layout->plant = plant;
  if (tl_channel_set_of(plant, &layout->set) != TL_OK) return app_fail(error, APP_FAILED, "unknown plant");
  for (int c = 0; c < TL_CHANNEL_COUNT; c++)
    layout->name[c] = layout->set.known & TL_CHANNEL_BIT(c) ? tl_channel_name((tl_channel)c) : NULL;
  layout->header = (struct csv_header){
      .path = path, .name = layout->name, .names = TL_CHANNEL_COUNT, .advice = layout->advice};
  if (snprintf(layout->advice, sizeof layout->advice,
               "; try: talus-import --plant %s --suggest --out recording.csv '%s'",
               tl_plant_facts(plant)->name, path) >= (int)sizeof layout->advice)
    layout->advice[0] = '\0';
  return 0;
}

static void list_set(struct csv_list *list, const char *separator, uint32_t set) {
  for (int c = 0; c < TL_CHANNEL_COUNT; c++)
    if (set & TL_CHANNEL_BIT(c)) csv_list_add(list, separator, tl_channel_name((tl_channel)c));
}

/* a line of candump's log, "(1436509052.249713) can0 044#2A36": a DBC says what it holds, and no map of columns */
static int is_bus_log(const struct csv_header *header) {
  int end = 0;
  sscanf(header->found.text, "(%*[0-9.]) %*s %*[0-9A-Fa-f]#%n", &end);
  return end > 0;
}

/* what to do instead of reading this file */
static void advise_export(struct layout *layout) {
  if (snprintf(
          layout->advice, sizeof layout->advice,
          "; a log of the bus, try: talus-acquire-export --dbc D.dbc --model M.yaml --out recording.csv '%s'",
          layout->header.path) >= (int)sizeof layout->advice)
    layout->advice[0] = '\0';
}

int layout_check(struct layout *layout, size_t line, struct app_error *error) {
  const tl_channel_set *set = &layout->set;
  struct csv_list missing = {"", 0};
  uint32_t there = 0;
  char why[64];
  for (size_t i = 0; i < layout->header.width; i++) there |= TL_CHANNEL_BIT(layout->header.column[i]);
  list_set(&missing, ", ", set->required & ~there);
  for (int i = 0; i < 2; i++) {
    struct csv_list choice = {"", 0};
    if (!set->any_of[i] || (set->any_of[i] & there)) continue;
    list_set(&choice, " or ", set->any_of[i]);
    csv_list_add(&missing, ", ", choice.text);
  }
  if (!missing.used) return 0;
  if (is_bus_log(&layout->header)) advise_export(layout);
  snprintf(why, sizeof why, " (a %s's recording needs it)", tl_plant_facts(layout->plant)->name);
  return csv_missing(&layout->header, line, missing.text, why, error);
}
