/* twin_orders.c: what the bus asks of the twin, without a bus, for tests/test_twin_orders.py.
 *
 *   twin_orders MODEL.yaml follow|own
 *
 * On standard input, a line each: a frame as "ID#DATA", or "tick", which prints
 * "STATE Q V Q V POWER MISSED CLAMPED": what the drives follow at knee and ankle, and are they powered.
 * "late NS..." prints the upper edges in us of half and of all of these lateness.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "leg_bus/lateness.h"
#include "leg_bus/orders.h"

static struct model_file file;
static tl_excitation excitation;
static tl_twin_settings settings;
static tl_limits limits[TL_MAX_JOINTS];
static tl_twin bench;
static struct orders orders;

static void take(const char *text) {
  struct leg_bus_frame frame = {0};
  char *data, pair[3] = "";

  frame.id = (uint32_t)strtoul(text, &data, 16);
  for (data++; data[0] && data[1]; data += 2) {
    memcpy(pair, data, 2);
    frame.data[frame.length++] = (uint8_t)strtoul(pair, NULL, 16);
  }
  orders_take(&orders, &frame);
}

static void tick(unsigned long number) {
  const double t_s = (double)number / settings.control_hz;
  tl_motion motion;

  orders_apply(&orders, t_s, &excitation, &bench);
  tl_excitation_at(&excitation, t_s, &motion);
  printf("%d %.17g %.17g %.17g %.17g %d %lu %lu\n", (int)orders.state, motion.q[0], motion.v[0], motion.q[1],
         motion.v[1], bench.settings.stiffness[0] > 0.0 && bench.settings.damping[1] > 0.0, orders.missed,
         orders.clamped);
}

static void late(char *text) {
  struct lateness l = {0};
  char *end = text;

  for (long long ns = strtoll(text, &end, 10); end != text; ns = strtoll(text, &end, 10)) {
    lateness_add(&l, ns, 1000000);
    text = end;
  }
  printf("%g %g %lu %lld\n", lateness_quantile_us(&l, 0.5), lateness_quantile_us(&l, 1.0), l.over,
         (long long)l.worst_ns);
}

int main(int argc, char **argv) {
  struct app_error error;
  unsigned long ticks = 0;
  char line[1024];

  if (argc != 3 || model_file_read(argv[1], &file, &error) != 0) return 2;
  orders_rest(&excitation, TL_MAX_JOINTS);
  settings = tl_twin_defaults(&file.model, &excitation);
  tl_twin_limits(&file.model, &settings, limits);
  if (tl_twin_init(&bench, &file.model, &excitation, &settings) != TL_OK) return 2;
  orders_init(&orders, &file.model, &settings, limits, strcmp(argv[2], "follow") == 0);
  printf("%.17g %.17g %.17g\n", settings.stiffness[0], settings.stiffness[1], settings.current_limit_A[0]);
  while (fgets(line, sizeof line, stdin)) {
    line[strcspn(line, "\n")] = '\0';
    if (strcmp(line, "tick") == 0)
      tick(ticks++);
    else if (strncmp(line, "late", 4) == 0)
      late(line + 4);
    else
      take(line);
  }
  return 0;
}
