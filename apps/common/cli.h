/* cli.h: a program's options from one table, which is also its help text.
 *
 *     static const char *model;
 *     static uint64_t seed = 1;
 *     static const struct cli_option options[] = {
 *         {"model", 'm', CLI_TEXT, &model, 1, "M.yaml", "the model to start from"},
 *         CLI_SEED_OPTION(&seed)};
 *     static const struct cli_program program = {
 *         .name = "talus-identify", .summary = "fits a model's parameters to recordings",
 *         .example = "talus-identify --model leg.yaml --out fitted.yaml run.csv",
 *         .arguments = "REC.csv...", .min_arguments = 1, .max_arguments = CLI_ANY,
 *         .option = options, .options = sizeof options / sizeof options[0]};
 *
 *     int first;
 *     switch (cli_parse(&program, argc, argv, &first)) {
 *     case CLI_RUN: break;             // recordings are argv[first] .. argv[argc - 1]
 *     case CLI_DONE: return APP_OK;    // --help or --version was printed
 *     case CLI_USAGE: return APP_BAD_INPUT;
 *     }
 *
 * --help and --version exist in every program and need no entry.
 */
#ifndef CLI_H
#define CLI_H

#include <stddef.h>
#include <stdint.h>

enum cli_kind {
  CLI_FLAG,   /* int: 1 when given */
  CLI_TEXT,   /* const char * */
  CLI_NUMBER, /* double, finite */
  CLI_WHOLE   /* uint64_t */
};

/* One option. Without short form `letter` is 0. */
struct cli_option {
  const char *name;
  char letter;
  enum cli_kind kind;
  void *target; /* holds the default until the option is given */
  int required;
  const char *value; /* how the help calls the value; NULL for a flag */
  const char *help;  /* one line, or several parted by newlines */
};

#define CLI_SEED_OPTION(target)                                                                              \
  { "seed", 0, CLI_WHOLE, target, 0, "N", "seed of all random numbers (default 1)" }

#define CLI_ANY (-1)
#define CLI_MAX_OPTIONS 48

struct cli_program {
  const char *name;
  const char *summary;   /* one line: what the program does */
  const char *example;   /* command lines that stand first in the help, parted by newlines */
  const char *arguments; /* how the help calls what is no option; NULL when there are none */
  int min_arguments, max_arguments;
  const struct cli_option *option;
  size_t options;   /* <= CLI_MAX_OPTIONS */
  const char *more; /* further paragraphs of the help; Nullable */
};

enum cli_result { CLI_RUN, CLI_DONE, CLI_USAGE };

/* Sets the targets, and *first to the index of the first argument that is no option (they
 * are moved behind the options). Also names the program for error.h and lets progress.h show. Prints the help to
 * standard output, complaints to standard error. */
enum cli_result cli_parse(const struct cli_program *program, int argc, char **argv, int *first);

/* A file that an option names. Nullable: path. */
struct cli_file {
  const char *option, *path;
};
/* No two results in one file. */
enum cli_result cli_keep_apart(const struct cli_file *result, int results);
/* No result in the place of an input, which is `what` ("the model"). */
enum cli_result cli_keep_input(const struct cli_file *result, int results, const char *input,
                               const char *what);

/* One line about wrong usage that the table cannot know, with the hint; answers CLI_USAGE. */
enum cli_result cli_complain(const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 1, 2)))
#endif
    ;

#endif
