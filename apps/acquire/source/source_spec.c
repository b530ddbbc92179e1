/* source_spec.c: "gpio:sync=gpiochip0:3:rising" taken apart. */
#include "source_spec.h"

#include <stdlib.h>
#include <string.h>

#include "common/decimal.h"

enum { FIELDS = 6, TEXT = 128 };

static const char *const kind_name[] = {"can", "gpio", "estop", "pulse", "fd"};

const char *source_kind_name(enum source_kind kind) {
  return kind_name[kind];
}

static int refuse(struct app_error *error, const char *text, const char *expected) {
  char shown[TEXT];
  return app_fail(error, APP_BAD_INPUT, "source '%s': expected %s",
                  app_printable(shown, sizeof shown, text, strlen(text)), expected);
}

/* the kind that the text begins with; without one it is a CAN interface */
static enum source_kind take_kind(const char **text) {
  for (int k = SOURCE_GPIO; k <= SOURCE_FD; k++) {
    const size_t n = strlen(kind_name[k]);
    if (strncmp(*text, kind_name[k], n) != 0 || (*text)[n] != ':') continue;
    *text += n + 1;
    return (enum source_kind)k;
  }
  return SOURCE_CAN;
}

/* cuts at ':' in place; answers the number of fields, or 0 when there are too many */
static int split(char *text, char *field[FIELDS]) {
  int n = 0;
  for (char *at = text; at; n++) {
    if (n == FIELDS) return 0;
    field[n] = at;
    at = strchr(at, ':');
    if (at) *at++ = '\0';
  }
  return n;
}

static int take_number(const char *text, double low, double high, double *value) {
  const char *end;
  return decimal_parse(text, value, &end) == DECIMAL_OK && *end == '\0' && *value >= low && *value <= high;
}

/* one word behind chip and line */
static int take_word(const char *word, struct gpio_line *line) {
  static const char *const edge[] = {
      [GPIO_RISING] = "rising", [GPIO_FALLING] = "falling", [GPIO_BOTH] = "both"};
  static const char *const pull[] = {[GPIO_PULL_UP] = "pull-up", [GPIO_PULL_DOWN] = "pull-down"};
  for (int e = GPIO_RISING; e <= GPIO_BOTH; e++)
    if (strcmp(word, edge[e]) == 0) return line->edges = (enum gpio_edges)e, 1;
  for (int p = GPIO_PULL_UP; p <= GPIO_PULL_DOWN; p++)
    if (strcmp(word, pull[p]) == 0) return line->pull = (enum gpio_pull)p, 1;
  return 0;
}

static int take_line(struct source_spec *spec, char *field[FIELDS], int fields) {
  struct gpio_line *line = &spec->line;
  if (fields < 2 || strlen(field[0]) >= sizeof line->chip || strlen(field[1]) >= sizeof line->name) return 0;
  memcpy(line->chip, field[0], strlen(field[0]) + 1);
  memcpy(line->name, field[1], strlen(field[1]) + 1);
  line->edges = spec->kind == SOURCE_ESTOP ? GPIO_FALLING : GPIO_BOTH;
  if (spec->kind != SOURCE_PULSE) {
    for (int i = 2; i < fields; i++)
      if (!take_word(field[i], line)) return 0;
    return line->chip[0] && line->name[0];
  }
  line->output = 1;
  if (fields < 3 || fields > 4 || !take_number(field[2], 1e-3, 1e3, &spec->rate_hz)) return 0;
  spec->high_s = 0.5 / spec->rate_hz;
  double high_ms;
  if (fields == 3) return 1;
  if (!take_number(field[3], 0.01, 999.0 / spec->rate_hz, &high_ms)) return 0;
  spec->high_s = 1e-3 * high_ms;
  return 1;
}

static int take_fd(struct source_spec *spec, const char *text) {
  double number;
  if (!take_number(text, 0, 1 << 20, &number)) return 0;
  spec->fd = (int)number;
  return spec->fd == number;
}

int source_spec_parse(const char *text, struct source_spec *spec, struct app_error *error) {
  static const char *const expected[] = {
      [SOURCE_CAN] = "a CAN interface of at most 15 letters",
      [SOURCE_GPIO] = "gpio:NAME=CHIP:LINE, then rising, falling or both, pull-up or pull-down",
      [SOURCE_ESTOP] = "estop:NAME=CHIP:LINE, then rising, falling or both, pull-up or pull-down",
      [SOURCE_PULSE] = "pulse:NAME=CHIP:LINE:HZ or pulse:NAME=CHIP:LINE:HZ:MS with MS below the period",
      [SOURCE_FD] = "fd:NAME=NUMBER"};
  const char *rest = text;
  memset(spec, 0, sizeof *spec);
  spec->fd = -1;
  spec->kind = take_kind(&rest);
  const size_t name = spec->kind == SOURCE_CAN ? strlen(rest) : strcspn(rest, "=");
  if (name == 0 || name >= sizeof spec->name || strcspn(rest, " /:\t\n") < name)
    return refuse(error, text, expected[spec->kind]);
  memcpy(spec->name, rest, name);
  if (spec->kind == SOURCE_CAN) return 0;
  char fields[TEXT], *field[FIELDS];
  if (rest[name] != '=' || strlen(rest + name + 1) >= sizeof fields)
    return refuse(error, text, expected[spec->kind]);
  memcpy(fields, rest + name + 1, strlen(rest + name + 1) + 1);
  const int ok =
      spec->kind == SOURCE_FD ? take_fd(spec, fields) : take_line(spec, field, split(fields, field));
  return ok ? 0 : refuse(error, text, expected[spec->kind]);
}
