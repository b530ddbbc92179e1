/* cli_demo.c: a program with one option of each kind, for tests/test_cli.py. */
#include <inttypes.h>
#include <stdio.h>

#include "common/cli.h"
#include "common/error.h"
#include "common/progress.h"

static int quick;
static const char *model, *note = "none";
static double width = 0.5;
static uint64_t seed = 1;

static const struct cli_option options[] = {
    {"model", 'm', CLI_TEXT, &model, 1, "M.yaml", "the model to read"},
    {"note", 0, CLI_TEXT, &note, 0, "TEXT", "what to remember\n(on two lines)"},
    {"width", 'w', CLI_NUMBER, &width, 0, "SECONDS", "a number"},
    {"quick", 'q', CLI_FLAG, &quick, 0, NULL, "a flag"},
    CLI_SEED_OPTION(&seed),
};

static const struct cli_program program = {
    .name = "cli_demo",
    .summary = "shows what it was told",
    .example = "cli_demo --model leg.yaml run.csv\n"
               "cli_demo --model leg.yaml --quick run1.csv run2.csv",
    .arguments = "REC.csv...",
    .min_arguments = 1,
    .max_arguments = 3,
    .option = options,
    .options = sizeof options / sizeof options[0],
    .more = "The end.",
};

int main(int argc, char **argv) {
  int first;
  struct progress progress;
  switch (cli_parse(&program, argc, argv, &first)) {
  case CLI_RUN: break;
  case CLI_DONE: return APP_OK;
  case CLI_USAGE: return APP_BAD_INPUT;
  }
  progress_begin(&progress, "working", "folder/file.csv");
  for (int i = 0; i <= 3000000; i++) progress_update(&progress, i / 3000000.0);
  progress_end(&progress);
  printf("%s|%s|%.17g|%d|%" PRIu64 "|", model, note, width, quick, seed);
  for (int i = first; i < argc; i++) printf("%s%s", i > first ? " " : "", argv[i]);
  putchar('\n');
  return APP_OK;
}
