/* gpio_libgpiod1.c: a line through libgpiod 1 (Debian 12). Its events carry no sequence number, and the kernel's
 * queue behind it holds 16: edges lost there do not show. */
#if defined(TALUS_GPIOD) && TALUS_GPIOD == 1
#define _GNU_SOURCE

#include <errno.h>
#include <gpiod.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>

#include "gpio.h"

enum { BATCH = 16, NS_PER_S = 1000000000 };

struct gpio {
  struct gpiod_chip *chip;
  struct gpiod_line *line;
  struct gpiod_line_event event[BATCH];
};

static void close_line(struct gpio *gpio) {
  if (!gpio) return;
  if (gpio->line) gpiod_line_release(gpio->line);
  if (gpio->chip) gpiod_chip_close(gpio->chip);
  free(gpio);
}

static struct gpiod_line *find_line(struct gpiod_chip *chip, const struct gpio_line *line) {
  const int offset = gpio_line_offset(line);
  return offset >= 0 ? gpiod_chip_get_line(chip, (unsigned)offset) : gpiod_chip_find_line(chip, line->name);
}

static int request(struct gpiod_line *handle, const struct gpio_line *line) {
  static const int kind[] = {GPIOD_LINE_REQUEST_DIRECTION_INPUT, GPIOD_LINE_REQUEST_EVENT_RISING_EDGE,
                             GPIOD_LINE_REQUEST_EVENT_FALLING_EDGE, GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES};
  static const int pull[] = {0, GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP, GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN};
  const struct gpiod_line_request_config config = {
      .consumer = "talus-acquire",
      .request_type = line->output ? GPIOD_LINE_REQUEST_DIRECTION_OUTPUT : kind[line->edges],
      .flags = line->output ? 0 : pull[line->pull]};
  return gpiod_line_request(handle, &config, 0);
}

static struct gpio *open_line(const struct gpio_line *line, struct app_error *error) {
  char path[80];
  const char *failed = NULL;
  struct gpio *gpio = calloc(1, sizeof *gpio);
  if (!gpio) {
    app_fail(error, APP_FAILED, "out of memory");
    return NULL;
  }
  gpio->chip = gpiod_chip_open(gpio_chip_path(line, path));
  if (!gpio->chip)
    failed = "the chip cannot be opened";
  else if (!(gpio->line = find_line(gpio->chip, line)))
    failed = "no such line";
  else if (request(gpio->line, line) != 0)
    failed = "the line cannot be had";
  if (!failed) return gpio;
  gpio_refuse(line, errno, failed, error);
  gpio->line = NULL;
  close_line(gpio);
  return NULL;
}

static int line_fd(const struct gpio *gpio) {
  return gpiod_line_event_get_fd(gpio->line);
}

static int read_edges(struct gpio *gpio, struct gpio_edge *edge, int most) {
  struct pollfd ready = {.fd = line_fd(gpio), .events = POLLIN};
  if (poll(&ready, 1, 0) <= 0) return 0; /* the library's read would wait */
  const int n =
      gpiod_line_event_read_multiple(gpio->line, gpio->event, (unsigned)(most < BATCH ? most : BATCH));
  for (int i = 0; i < n; i++) {
    const struct gpiod_line_event *e = &gpio->event[i];
    edge[i] = (struct gpio_edge){(int64_t)e->ts.tv_sec * NS_PER_S + e->ts.tv_nsec,
                                 e->event_type == GPIOD_LINE_EVENT_RISING_EDGE, 0};
  }
  return n;
}

static int get_level(struct gpio *gpio) {
  return gpiod_line_get_value(gpio->line);
}

static int set_level(struct gpio *gpio, int value) {
  return gpiod_line_set_value(gpio->line, value);
}

const struct gpio_backend gpio_libgpiod = {"libgpiod1", open_line, line_fd,   read_edges,
                                           get_level,   set_level, close_line};

#else
typedef int gpio_libgpiod1_is_not_built; /* C wants something in every file */
#endif
