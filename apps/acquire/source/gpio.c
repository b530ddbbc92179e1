/* gpio.c: the choice of a back end, and what they share. */
#include "gpio.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct gpio_backend *const backend[] = {
    &gpio_kernel,
#if defined(TALUS_GPIOD)
    &gpio_libgpiod,
#endif
};

const struct gpio_backend *gpio_backend(const char *name) {
  for (size_t i = 0; i < sizeof backend / sizeof backend[0]; i++)
    if (!name || strcmp(name, backend[i]->name) == 0) return backend[i];
  return NULL;
}

const char *gpio_backend_names(void) {
#if defined(TALUS_GPIOD) && TALUS_GPIOD == 1
  return "kernel, libgpiod1";
#elif defined(TALUS_GPIOD)
  return "kernel, libgpiod2";
#else
  return "kernel";
#endif
}

const char *gpio_chip_path(const struct gpio_line *line, char out[80]) {
  snprintf(out, 80, "%s%s", line->chip[0] == '/' ? "" : "/dev/", line->chip);
  return out;
}

int gpio_line_offset(const struct gpio_line *line) {
  char *end;
  const long offset = strtol(line->name, &end, 10);
  return line->name[0] >= '0' && line->name[0] <= '9' && !*end && offset < 1 << 16 ? (int)offset : -1;
}

int gpio_refuse(const struct gpio_line *line, int reason, const char *what, struct app_error *error) {
  return app_fail(error, APP_BAD_INPUT, "GPIO line %s:%s: %s: %s", line->chip, line->name, what,
                  strerror(reason));
}
