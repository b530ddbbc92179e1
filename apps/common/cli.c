/* cli.c: getopt_long from a table. */
#define _GNU_SOURCE /* getopt_long */

#include "cli.h"

#include <errno.h>
#include <getopt.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "decimal.h"
#include "error.h"
#include "output.h"
#include "progress.h"
#include "talus/version.h"

/* what getopt_long answers: the table's index from here on, then the two common ones */
enum { FIRST = 1000, HELP = FIRST + CLI_MAX_OPTIONS, VERSION };
enum { HELP_COLUMN = 26 };

enum cli_result cli_complain(const char *format, ...) {
  char text[512];
  va_list arguments;
  struct app_error error;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  app_fail(&error, APP_BAD_INPUT, "%s (%s --help tells more)", text, app_name());
  app_exit(&error);
  return CLI_USAGE;
}

/* ---- help -------------------------------------------------------------------- */

/* "  -m, --model M.yaml      text", further lines below the text */
static void print_option(const char *name, char letter, const char *value, const char *help) {
  char left[128];
  const int n = snprintf(left, sizeof left, letter ? "  -%c, --%s%s%s" : "  %c   --%s%s%s",
                         letter ? letter : ' ', name, value ? " " : "", value ? value : "");
  printf("%-*s", HELP_COLUMN, left);
  if (n >= HELP_COLUMN) printf("\n%*s", HELP_COLUMN, "");
  for (; *help; help++) {
    putchar(*help);
    if (*help == '\n') printf("%*s", HELP_COLUMN, "");
  }
  putchar('\n');
}

/* what a newcomer copies: command lines, each indented */
static void print_example(const char *example) {
  printf("\n    ");
  for (; *example; example++) {
    putchar(*example);
    if (*example == '\n') printf("    ");
  }
  putchar('\n');
}

static void print_help(const struct cli_program *p) {
  printf("usage: %s", p->name);
  for (size_t i = 0; i < p->options; i++)
    if (p->option[i].required) printf(" --%s %s", p->option[i].name, p->option[i].value);
  printf(" [OPTION...]%s%s\n", p->arguments ? " " : "", p->arguments ? p->arguments : "");
  print_example(p->example);
  printf("\n%s\n\n", p->summary);
  for (size_t i = 0; i < p->options; i++)
    print_option(p->option[i].name, p->option[i].letter, p->option[i].value, p->option[i].help);
  print_option("help", 'h', NULL, "print this text");
  print_option("version", 0, NULL, "print the version");
  if (p->more) printf("\n%s\n", p->more);
}

/* ---- values -------------------------------------------------------------------- */

static int read_number(const char *text, double *x) {
  const char *end;
  return decimal_parse(text, x, &end) == DECIMAL_OK && *end == '\0';
}

static int read_whole(const char *text, uint64_t *x) {
  char *end;
  if (text[0] < '0' || text[0] > '9') return 0;
  errno = 0;
  const uintmax_t value = strtoumax(text, &end, 10);
  if (errno || *end || value > UINT64_MAX) return 0;
  *x = (uint64_t)value;
  return 1;
}

static enum cli_result set(const struct cli_option *o, const char *text) {
  switch (o->kind) {
  case CLI_FLAG: *(int *)o->target = 1; return CLI_RUN;
  case CLI_TEXT: *(const char **)o->target = text; return CLI_RUN;
  case CLI_NUMBER:
    if (read_number(text, o->target)) return CLI_RUN;
    return cli_complain("--%s: expected a number, found '%.40s'", o->name, text);
  case CLI_WHOLE:
    if (read_whole(text, o->target)) return CLI_RUN;
    return cli_complain("--%s: expected a whole number, found '%.40s'", o->name, text);
  }
  return CLI_USAGE;
}

/* ---- parsing -------------------------------------------------------------------- */

/* getopt's own tables: ":hm:" and the long names */
static void fill_tables(const struct cli_program *p, char *letters, struct option *table) {
  *letters++ = ':';
  *letters++ = 'h';
  size_t i;
  for (i = 0; i < p->options; i++) {
    const struct cli_option *o = &p->option[i];
    table[i] =
        (struct option){o->name, o->kind == CLI_FLAG ? no_argument : required_argument, NULL, FIRST + (int)i};
    if (!o->letter) continue;
    *letters++ = o->letter;
    if (o->kind != CLI_FLAG) *letters++ = ':';
  }
  table[i++] = (struct option){"help", no_argument, NULL, HELP};
  table[i++] = (struct option){"version", no_argument, NULL, VERSION};
  table[i] = (struct option){NULL, 0, NULL, 0};
  *letters = '\0';
}

/* the table's index for what getopt answered, or -1 */
static int find(const struct cli_program *p, int answer) {
  if (answer >= FIRST) return answer - FIRST;
  for (size_t i = 0; i < p->options; i++)
    if (p->option[i].letter && p->option[i].letter == answer) return (int)i;
  return -1;
}

static enum cli_result handle(const struct cli_program *p, int answer, char **argv, int *given) {
  if (answer == HELP || answer == 'h') {
    print_help(p);
    return CLI_DONE;
  }
  if (answer == VERSION) {
    printf("%s %s\n", p->name, tl_version());
    return CLI_DONE;
  }
  if (answer == ':') return cli_complain("%s needs a value", argv[optind - 1]);
  if (answer == '?') {
    if (optopt >= FIRST) return cli_complain("%s: this option takes no value", argv[optind - 1]);
    if (optopt) return cli_complain("unknown option -%c", optopt);
    return cli_complain("unknown or ambiguous option %s", argv[optind - 1]);
  }
  const int i = find(p, answer);
  given[i] = 1;
  return set(&p->option[i], optarg);
}

static enum cli_result check_given(const struct cli_program *p, const int *given, int arguments) {
  for (size_t i = 0; i < p->options; i++)
    if (p->option[i].required && !given[i])
      return cli_complain("--%s %s is missing", p->option[i].name, p->option[i].value);
  if (arguments < p->min_arguments) return cli_complain("%s is missing", p->arguments);
  if (p->max_arguments != CLI_ANY && arguments > p->max_arguments)
    return cli_complain("more arguments than expected, or one that should follow an option");
  return CLI_RUN;
}

enum cli_result cli_parse(const struct cli_program *program, int argc, char **argv, int *first) {
  char letters[2 * CLI_MAX_OPTIONS + 3];
  struct option table[CLI_MAX_OPTIONS + 3];
  int given[CLI_MAX_OPTIONS] = {0}, answer;
  app_set_name(program->name);
  progress_show(1);
  fill_tables(program, letters, table);
  opterr = 0;
  while ((answer = getopt_long(argc, argv, letters, table, NULL)) != -1) {
    const enum cli_result result = handle(program, answer, argv, given);
    if (result != CLI_RUN) return result;
  }
  *first = optind;
  return check_given(program, given, argc - optind);
}

enum cli_result cli_keep_apart(const struct cli_file *result, int results) {
  for (int i = 1; i < results; i++)
    for (int j = 0; j < i; j++)
      if (result[i].path && result[j].path && output_same(result[i].path, result[j].path))
        return cli_complain("--%s and --%s are one file, %s", result[j].option, result[i].option,
                            result[i].path);
  return CLI_RUN;
}

enum cli_result cli_keep_input(const struct cli_file *result, int results, const char *input,
                               const char *what) {
  for (int i = 0; i < results; i++)
    if (result[i].path && output_same(result[i].path, input))
      return cli_complain("--%s: %s is %s, it would be lost", result[i].option, input, what);
  return CLI_RUN;
}
