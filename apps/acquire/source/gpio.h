/* gpio.h: one GPIO line, whichever library or kernel interface serves it.
 *
 *     struct gpio *g = gpio_open(gpio_backend(NULL), &line, &error);
 *     poll gpio_fd(g); gpio_read(g, edge, n);
 *     gpio_close(g);
 *
 * Back ends: "kernel" (the kernel's own interface, version 2: sequence numbers, so that lost edges show) is
 * always there; "libgpiod1" or "libgpiod2" where the program was built with that library.
 */
#ifndef GPIO_H
#define GPIO_H

#include <stdint.h>

#include "common/error.h"

enum gpio_edges { GPIO_NO_EDGES, GPIO_RISING, GPIO_FALLING, GPIO_BOTH };
enum gpio_pull { GPIO_AS_IS, GPIO_PULL_UP, GPIO_PULL_DOWN };

struct gpio_line {
  char chip[64]; /* "gpiochip0" or a path */
  char name[64]; /* offset, or the line's name */
  enum gpio_edges edges;
  enum gpio_pull pull;
  int output; /* driven, beginning low; then there are no edges */
};

struct gpio_edge {
  int64_t mono_ns;   /* the kernel's stamp, CLOCK_MONOTONIC */
  int value;         /* the level after the edge */
  uint32_t sequence; /* of the line, from 1; 0: this back end has none */
};

struct gpio;

/* What a back end consists of. */
struct gpio_backend {
  const char *name;
  struct gpio *(*open)(const struct gpio_line *line, struct app_error *error);
  int (*fd)(const struct gpio *gpio); /* readable when there is an edge */
  /* up to `most` edges that are there; 0 none, -1 with errno; never waits */
  int (*read)(struct gpio *gpio, struct gpio_edge *edge, int most);
  int (*get)(struct gpio *gpio);            /* the level now; -1 with errno */
  int (*set)(struct gpio *gpio, int value); /* -1 with errno */
  void (*close)(struct gpio *gpio);
};

/* By name, or the default for NULL; NULL when there is none of that name. */
const struct gpio_backend *gpio_backend(const char *name);
/* All names, with commas. */
const char *gpio_backend_names(void);

/* "/dev/gpiochip0" of "gpiochip0", into out[80]. */
const char *gpio_chip_path(const struct gpio_line *line, char out[80]);
/* The offset when the line's name is a number, else -1. */
int gpio_line_offset(const struct gpio_line *line);
/* The usual complaint; -1. */
int gpio_refuse(const struct gpio_line *line, int reason, const char *what, struct app_error *error);

extern const struct gpio_backend gpio_kernel;
#if defined(TALUS_GPIOD)
extern const struct gpio_backend gpio_libgpiod;
#endif

#endif
