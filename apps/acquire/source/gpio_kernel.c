/* gpio_kernel.c: a line through the kernel's own interface, version 2 (Linux 5.10 and later). */
#define _GNU_SOURCE

#include <errno.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "gpio.h"

enum { BATCH = 64, KERNEL_QUEUE = 1024 };

struct gpio {
  int fd;
  struct gpio_v2_line_event event[BATCH];
};

/* the offset of the line, by number or by name; -1 with errno */
static int find_offset(int chip, const struct gpio_line *line) {
  struct gpiochip_info info = {.lines = 0};
  if (ioctl(chip, GPIO_GET_CHIPINFO_IOCTL, &info) != 0) return -1;
  const int number = gpio_line_offset(line);
  errno = ENOENT;
  if (number >= 0) return (uint32_t)number < info.lines ? number : -1;
  for (uint32_t i = 0; i < info.lines; i++) {
    struct gpio_v2_line_info one;
    memset(&one, 0, sizeof one);
    one.offset = i;
    if (ioctl(chip, GPIO_V2_GET_LINEINFO_IOCTL, &one) == 0 && strcmp(one.name, line->name) == 0)
      return (int)i;
  }
  errno = ENOENT;
  return -1;
}

static uint64_t flags_of(const struct gpio_line *line) {
  static const uint64_t pull[] = {0, GPIO_V2_LINE_FLAG_BIAS_PULL_UP, GPIO_V2_LINE_FLAG_BIAS_PULL_DOWN};
  static const uint64_t edge[] = {0, GPIO_V2_LINE_FLAG_EDGE_RISING, GPIO_V2_LINE_FLAG_EDGE_FALLING,
                                  GPIO_V2_LINE_FLAG_EDGE_RISING | GPIO_V2_LINE_FLAG_EDGE_FALLING};
  if (line->output) return GPIO_V2_LINE_FLAG_OUTPUT;
  return GPIO_V2_LINE_FLAG_INPUT | pull[line->pull] | edge[line->edges];
}

static int request(int chip, int offset, const struct gpio_line *line) {
  struct gpio_v2_line_request r;
  memset(&r, 0, sizeof r);
  r.offsets[0] = (uint32_t)offset;
  r.num_lines = 1;
  memcpy(r.consumer, "talus-acquire", sizeof "talus-acquire");
  r.config.flags = flags_of(line);
  r.event_buffer_size = line->output ? 0 : KERNEL_QUEUE;
  return ioctl(chip, GPIO_V2_GET_LINE_IOCTL, &r) == 0 ? r.fd : -1;
}

static struct gpio *open_line(const struct gpio_line *line, struct app_error *error) {
  char path[80];
  struct gpio *gpio = NULL;
  const int chip = open(gpio_chip_path(line, path), O_RDWR | O_CLOEXEC);
  if (chip < 0) {
    gpio_refuse(line, errno, "the chip cannot be opened", error);
    return NULL;
  }
  const int offset = find_offset(chip, line);
  if (offset < 0) {
    gpio_refuse(line, errno, "no such line", error);
  } else {
    const int fd = request(chip, offset, line);
    if (fd < 0) gpio_refuse(line, errno, "the line cannot be had", error);
    if (fd >= 0 && !(gpio = calloc(1, sizeof *gpio))) close(fd);
    if (gpio) {
      gpio->fd = fd;
      fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
    }
  }
  close(chip);
  return gpio;
}

static int line_fd(const struct gpio *gpio) {
  return gpio->fd;
}

static int read_edges(struct gpio *gpio, struct gpio_edge *edge, int most) {
  const size_t wanted = (size_t)(most < BATCH ? most : BATCH);
  const ssize_t n = read(gpio->fd, gpio->event, wanted * sizeof gpio->event[0]);
  if (n < 0) return errno == EAGAIN || errno == EINTR ? 0 : -1;
  const int edges = (int)((size_t)n / sizeof gpio->event[0]);
  for (int i = 0; i < edges; i++) {
    const struct gpio_v2_line_event *e = &gpio->event[i];
    edge[i] =
        (struct gpio_edge){(int64_t)e->timestamp_ns, e->id == GPIO_V2_LINE_EVENT_RISING_EDGE, e->line_seqno};
  }
  return edges;
}

static int get_level(struct gpio *gpio) {
  struct gpio_v2_line_values values = {.bits = 0, .mask = 1};
  if (ioctl(gpio->fd, GPIO_V2_LINE_GET_VALUES_IOCTL, &values) != 0) return -1;
  return (int)(values.bits & 1);
}

static int set_level(struct gpio *gpio, int value) {
  struct gpio_v2_line_values values = {.bits = value ? 1 : 0, .mask = 1};
  return ioctl(gpio->fd, GPIO_V2_LINE_SET_VALUES_IOCTL, &values);
}

static void close_line(struct gpio *gpio) {
  if (!gpio) return;
  close(gpio->fd);
  free(gpio);
}

const struct gpio_backend gpio_kernel = {"kernel",  open_line, line_fd,   read_edges,
                                         get_level, set_level, close_line};
