/* fake_gpio.c: preloaded, it is a GPIO chip for a kernel that has none (the UML guest), for tests whose subject is what an
 * edge does on a real CAN interface. Every line's events are what the test writes into the FIFO $FAKE_GPIO/events, in the
 * kernel's layout; its level is the character in $FAKE_GPIO/level. */
#define _GNU_SOURCE

#include <fcntl.h>
#include <linux/gpio.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

static int open_part(const char *part, int flags) {
  char path[4096];
  snprintf(path, sizeof path, "%s/%s", getenv("FAKE_GPIO"), part);
  return (int)syscall(SYS_openat, AT_FDCWD, path, flags | O_CLOEXEC, 0);
}

static int any_open(const char *path, int flags, mode_t mode) {
  if (strcmp(path, "/dev/fakechip") == 0) return open_part("level", O_RDONLY);
  return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

int open(const char *path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = va_arg(arguments, mode_t);
  va_end(arguments);
  return any_open(path, flags, mode);
}

int open64(const char *path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = va_arg(arguments, mode_t);
  va_end(arguments);
  return any_open(path, flags, mode);
}

static int level(void) {
  char c = '0';
  const int fd = open_part("level", O_RDONLY);
  if (fd < 0 || read(fd, &c, 1) != 1) c = '0';
  close(fd);
  return c == '1';
}

int ioctl(int fd, unsigned long request, ...) {
  va_list arguments;
  va_start(arguments, request);
  void *data = va_arg(arguments, void *);
  va_end(arguments);
  if (request == GPIO_GET_CHIPINFO_IOCTL) return ((struct gpiochip_info *)data)->lines = 8, 0;
  if (request == GPIO_V2_GET_LINE_IOCTL)
    return ((struct gpio_v2_line_request *)data)->fd = open_part("events", O_RDWR | O_NONBLOCK), 0;
  if (request == GPIO_V2_LINE_GET_VALUES_IOCTL)
    return ((struct gpio_v2_line_values *)data)->bits = (unsigned)level(), 0;
  return (int)syscall(SYS_ioctl, fd, request, data);
}
