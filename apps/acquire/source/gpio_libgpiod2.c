/* gpio_libgpiod2.c: a line through libgpiod 2 (Debian 13). */
#if defined(TALUS_GPIOD) && TALUS_GPIOD == 2
#define _GNU_SOURCE

#include <errno.h>
#include <gpiod.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>

#include "gpio.h"

enum { BATCH = 64, KERNEL_QUEUE = 1024 };

struct gpio {
  unsigned offset;
  struct gpiod_line_request *request;
  struct gpiod_edge_event_buffer *buffer;
};

static void close_line(struct gpio *gpio) {
  if (!gpio) return;
  if (gpio->request) gpiod_line_request_release(gpio->request);
  if (gpio->buffer) gpiod_edge_event_buffer_free(gpio->buffer);
  free(gpio);
}

static int fill_settings(struct gpiod_line_settings *s, const struct gpio_line *line) {
  static const enum gpiod_line_edge edge[] = {GPIOD_LINE_EDGE_NONE, GPIOD_LINE_EDGE_RISING,
                                              GPIOD_LINE_EDGE_FALLING, GPIOD_LINE_EDGE_BOTH};
  static const enum gpiod_line_bias bias[] = {GPIOD_LINE_BIAS_AS_IS, GPIOD_LINE_BIAS_PULL_UP,
                                              GPIOD_LINE_BIAS_PULL_DOWN};
  if (line->output) return gpiod_line_settings_set_direction(s, GPIOD_LINE_DIRECTION_OUTPUT);
  if (gpiod_line_settings_set_direction(s, GPIOD_LINE_DIRECTION_INPUT) != 0) return -1;
  if (gpiod_line_settings_set_event_clock(s, GPIOD_LINE_CLOCK_MONOTONIC) != 0) return -1;
  if (gpiod_line_settings_set_bias(s, bias[line->pull]) != 0) return -1;
  return gpiod_line_settings_set_edge_detection(s, edge[line->edges]);
}

/* the three objects that a request is made of live as long as this function */
static struct gpiod_line_request *request(struct gpiod_chip *chip, unsigned offset,
                                          const struct gpio_line *line) {
  struct gpiod_line_settings *settings = gpiod_line_settings_new();
  struct gpiod_line_config *lines = gpiod_line_config_new();
  struct gpiod_request_config *config = gpiod_request_config_new();
  struct gpiod_line_request *made = NULL;
  if (settings && lines && config && fill_settings(settings, line) == 0 &&
      gpiod_line_config_add_line_settings(lines, &offset, 1, settings) == 0) {
    gpiod_request_config_set_consumer(config, "talus-acquire");
    gpiod_request_config_set_event_buffer_size(config, KERNEL_QUEUE);
    made = gpiod_chip_request_lines(chip, config, lines);
  }
  const int reason = errno;
  if (settings) gpiod_line_settings_free(settings);
  if (lines) gpiod_line_config_free(lines);
  if (config) gpiod_request_config_free(config);
  errno = reason;
  return made;
}

/* by number, if the chip has as many, or by name; -1 with errno */
static int find_offset(struct gpiod_chip *chip, const struct gpio_line *line) {
  const int number = gpio_line_offset(line);
  if (number < 0) return gpiod_chip_get_line_offset_from_name(chip, line->name);
  struct gpiod_chip_info *info = gpiod_chip_get_info(chip);
  if (!info) return -1;
  const size_t lines = gpiod_chip_info_get_num_lines(info);
  gpiod_chip_info_free(info);
  errno = ENOENT;
  return (size_t)number < lines ? number : -1;
}

/* what failed, or NULL; errno says why */
static const char *open_on(struct gpiod_chip *chip, struct gpio *gpio, const struct gpio_line *line) {
  const int offset = find_offset(chip, line);
  if (offset < 0) return "no such line";
  gpio->offset = (unsigned)offset;
  gpio->buffer = gpiod_edge_event_buffer_new(BATCH);
  gpio->request = gpio->buffer ? request(chip, gpio->offset, line) : NULL;
  return gpio->request ? NULL : "the line cannot be had";
}

static struct gpio *open_line(const struct gpio_line *line, struct app_error *error) {
  char path[80];
  struct gpio *gpio = calloc(1, sizeof *gpio);
  struct gpiod_chip *chip = gpio ? gpiod_chip_open(gpio_chip_path(line, path)) : NULL;
  const char *failed = chip ? open_on(chip, gpio, line) : "the chip cannot be opened";
  const int reason = errno;
  if (chip) gpiod_chip_close(chip);
  if (!failed) return gpio;
  gpio_refuse(line, reason, failed, error);
  close_line(gpio);
  return NULL;
}

static int line_fd(const struct gpio *gpio) {
  return gpiod_line_request_get_fd(gpio->request);
}

static int read_edges(struct gpio *gpio, struct gpio_edge *edge, int most) {
  struct pollfd ready = {.fd = line_fd(gpio), .events = POLLIN};
  if (poll(&ready, 1, 0) <= 0) return 0; /* the library's read would wait */
  const size_t wanted = (size_t)(most < BATCH ? most : BATCH);
  const int n = gpiod_line_request_read_edge_events(gpio->request, gpio->buffer, wanted);
  for (int i = 0; i < n; i++) {
    struct gpiod_edge_event *e = gpiod_edge_event_buffer_get_event(gpio->buffer, (unsigned long)i);
    const int rising = gpiod_edge_event_get_event_type(e) == GPIOD_EDGE_EVENT_RISING_EDGE;
    edge[i] = (struct gpio_edge){(int64_t)gpiod_edge_event_get_timestamp_ns(e), rising,
                                 (uint32_t)gpiod_edge_event_get_line_seqno(e)};
  }
  return n;
}

static int get_level(struct gpio *gpio) {
  return gpiod_line_request_get_value(gpio->request, gpio->offset);
}

static int set_level(struct gpio *gpio, int value) {
  return gpiod_line_request_set_value(gpio->request, gpio->offset,
                                      value ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE);
}

const struct gpio_backend gpio_libgpiod = {"libgpiod2", open_line, line_fd,   read_edges,
                                           get_level,   set_level, close_line};

#else
typedef int gpio_libgpiod2_is_not_built; /* C wants something in every file */
#endif
