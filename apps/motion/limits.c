/* limits.c: see limits.h. */
#include "limits.h"

#include <string.h>

#include "common/decimal.h"

static int take_word(const char **text, const char *word) {
  const size_t n = strlen(word);
  if (strncmp(*text, word, n) != 0) return 0;
  *text += n;
  return 1;
}

static int take_number(const char **text, double *value) {
  return decimal_parse(*text, value, text) == DECIMAL_OK;
}

static int take_position(const char **text, tl_limits *limit) {
  return take_number(text, &limit->position_low) && take_word(text, ":") &&
         take_number(text, &limit->position_high) && limit->position_low < limit->position_high;
}

/* ".speed=4" behind a joint's name */
static int take_quantity(const char **text, tl_limits *limit) {
  const struct {
    const char *word;
    double *value;
  } quantity[] = {
      {".speed=", &limit->speed}, {".acceleration=", &limit->acceleration}, {".torque=", &limit->torque}};
  if (take_word(text, ".position=")) return take_position(text, limit);
  for (size_t q = 0; q < sizeof quantity / sizeof quantity[0]; q++)
    if (take_word(text, quantity[q].word))
      return take_number(text, quantity[q].value) && *quantity[q].value > 0.0;
  return 0;
}

/* one limit at *text, up to its comma or the end */
static int take_limit(const char **text, const tl_model *model, tl_limits limit[TL_MAX_JOINTS]) {
  for (int j = 0; j < tl_joint_count(model); j++)
    if (take_word(text, tl_joint_name(model, j)))
      return take_quantity(text, &limit[j]) && (**text == '\0' || **text == ',');
  return 0;
}

int limits_read(const char *text, const tl_model *model, tl_limits limit[TL_MAX_JOINTS],
                struct app_error *error) {
  tl_limits read[TL_MAX_JOINTS];
  memcpy(read, limit, sizeof read);
  for (const char *at = text, *here = text; *at; at += *at == ',', here = at)
    if (!take_limit(&at, model, read))
      return app_fail(error, APP_BAD_INPUT,
                      "--limits: expected for instance %s.position=-0.9:0.1 or %s.speed=4, found '%.40s'",
                      tl_joint_name(model, 0), tl_joint_name(model, tl_joint_count(model) - 1), here);
  memcpy(limit, read, sizeof read);
  return 0;
}
