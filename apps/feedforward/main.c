/* talus-feedforward: torque feedforward of a leg at 1 kHz, from an identified model, to drives that hold its position. */
#include <string.h>

#include "common/cli.h"
#include "comparison.h"

static struct comparison twin = {.seed = 1, .speed_lag_s = FEED_SPEED_LAG_S, .drives = CONTROLLER_DEFAULTS};

static const struct cli_option options[] = {
    {"play", 'p', CLI_TEXT, &twin.motion, 1, "TRAJ.csv",
     "the motion: time_s and joint angles (docs/trajectory.md)"},
    {"twin", 0, CLI_TEXT, &twin.truth, 1, "TRUTH.yaml",
     "the bench is the simulated one of this model, in lock-step:\nno bus, no clock, every model in turn and "
     "none"},
    {"report", 0, CLI_TEXT, &twin.report, 0, "R.json", "--twin's figures as JSON too"},
    {"speed-lag", 0, CLI_NUMBER, &twin.speed_lag_s, 0, "S",
     "how late the speed is that the drives measure;\nthey are told theirs as late (default 0.00164)"},
    CONTROLLER_OPTIONS(twin.drives),
    CLI_SEED_OPTION(&twin.seed),
};

static const struct cli_program program = {
    .name = "talus-feedforward",
    .summary = "moves a leg with the torque that its model asks for, beside the drives' position control",
    .arguments = "MODEL.yaml...",
    .min_arguments = 1,
    .max_arguments = COMPARISON_MODELS,
    .option = options,
    .options = sizeof options / sizeof options[0],
    .more = "An effect of a model that has no fast form (docs/controller.md) is named and nothing is moved.",
};

static enum cli_result check_files(int models, char **model) {
  const struct cli_file result = {"report", twin.report};
  enum cli_result answer = cli_keep_input(&result, 1, twin.truth, "the bench's model");

  if (twin.speed_lag_s < 0.0 || twin.speed_lag_s > 0.1)
    return cli_complain("--speed-lag: %g is not within 0 to 0.1", twin.speed_lag_s);
  if (answer == CLI_RUN) answer = cli_keep_input(&result, 1, twin.motion, "the motion");
  for (int i = 0; i < models && answer == CLI_RUN; i++)
    answer = cli_keep_input(&result, 1, model[i], "a model");
  return answer;
}

int main(int argc, char **argv) {
  struct app_error error;
  int first;
  enum cli_result result = cli_parse(&program, argc, argv, &first);

  if (result == CLI_RUN) result = check_files(argc - first, argv + first);
  if (result == CLI_DONE) return APP_OK;
  if (result == CLI_USAGE) return APP_BAD_INPUT;
  return comparison_run(&twin, argc - first, argv + first, &error) == 0 ? APP_OK : app_exit(&error);
}
