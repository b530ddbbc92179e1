/* talus-feedforward: torque feedforward of a leg at 1 kHz, from an identified model, to drives that hold its position. */
#define _GNU_SOURCE

#include <string.h>

#include "common/cli.h"
#include "comparison.h"
#include "loop.h"

static struct comparison twin = {.seed = 1};
static struct loop_settings bus = {
    .session = {.realtime = 1, .play_latest_s = 0.05, .source = {.receive_bytes = RECEIVE_BYTES}}};
static struct controller_options drives = CONTROLLER_DEFAULTS;
static const char *motion, *backend;
static double speed_lag_s = FEED_SPEED_LAG_S;
static int no_realtime;

static const struct cli_option options[] = {
    {"play", 'p', CLI_TEXT, &motion, 1, "TRAJ.csv",
     "the motion: time_s and joint angles (docs/trajectory.md)"},
    {"twin", 0, CLI_TEXT, &twin.truth, 0, "TRUTH.yaml",
     "the bench is the simulated one of this model, in lock-step:\nno bus, no clock, every model in turn and "
     "none"},
    {"report", 0, CLI_TEXT, &twin.report, 0, "R.json", "--twin's figures as JSON too"},
    {"html", 0, CLI_TEXT, &twin.html, 0, "P.html", "--twin's angles, errors and torques as a page"},
    {"can", 0, CLI_TEXT, &bus.can, 0, "IF", "the bench is on this CAN interface (models/leg.dbc)"},
    {"out", 'o', CLI_TEXT, &bus.session.out, 0, "REC[.log]",
     "--can: write REC.log (frames) and REC.jsonl (all else); required"},
    {"limits", 0, CLI_TEXT, &bus.session.limits, 0, "LIST",
     "--can: what the joints can do, for instance\nknee.position=-0.9:0.9,knee.speed=4 (and acceleration); "
     "required"},
    {"estop", 0, CLI_TEXT, &bus.estop, 0, "NAME=CHIP:LINE[:EDGES]",
     "--can: an edge (falling) of this line stops the drives"},
    {"play-latest", 0, CLI_NUMBER, &bus.session.play_latest_s, 0, "S",
     "--can: a tick later than S ends the motion (0.05)"},
    {"overwrite", 0, CLI_FLAG, &bus.session.overwrite, 0, NULL, "--can: replace files of that name"},
    {"quiet", 'q', CLI_FLAG, &bus.session.quiet, 0, NULL, "--can: no live line, no summary"},
    {"no-realtime", 0, CLI_FLAG, &no_realtime, 0, NULL, "--can: ask for no priority and no locked memory"},
    {"gpio-backend", 0, CLI_TEXT, &backend, 0, "NAME",
     "--can: kernel (default), or libgpiod1 or libgpiod2 where built in"},
    {"speed-lag", 0, CLI_NUMBER, &speed_lag_s, 0, "S",
     "how late the speed is that the drives measure;\nthey are told theirs as late (default 0.00164)"},
    CONTROLLER_OPTIONS(drives),
    CLI_SEED_OPTION(&twin.seed),
};

static const struct cli_program program = {
    .name = "talus-feedforward",
    .summary = "moves a leg with the torque that its model asks for, beside the drives' position control",
    .example = "talus-feedforward --twin truth.yaml --play gait.csv --html feed.html cad.yaml fitted.yaml\n"
               "talus-feedforward --can can0 --play gait.csv --out walk --limits knee.speed=4,ankle.speed=3 "
               "fitted.yaml",
    .arguments = "MODEL.yaml...",
    .min_arguments = 1,
    .max_arguments = COMPARISON_MODELS,
    .option = options,
    .options = sizeof options / sizeof options[0],
    .more = "An effect of a model that has no fast form (docs/controller.md) is named and nothing is moved.",
};

/* ---- the command line ------------------------------------------------------------- */

static enum cli_result check_twin(int models, char **model) {
  const struct cli_file result[] = {{"report", twin.report}, {"html", twin.html}};
  enum cli_result answer;

  if (bus.session.out || bus.session.limits || bus.estop)
    return cli_complain("--out, --limits and --estop go with --can");
  answer = cli_keep_input(result, 2, twin.truth, "the bench's model");
  if (answer == CLI_RUN) answer = cli_keep_input(result, 2, motion, "the motion");
  for (int i = 0; i < models && answer == CLI_RUN; i++)
    answer = cli_keep_input(result, 2, model[i], "a model");
  return answer;
}

static enum cli_result check_can(int models) {
  if (models != 1) return cli_complain("--can: expected one MODEL.yaml, found %d", models);
  if (twin.report || twin.html) return cli_complain("--report and --html go with --twin");
  if (!bus.session.out || !bus.session.limits)
    return cli_complain("--can: needs %s", bus.session.out ? "--limits" : "--out");
  if (bus.session.play_latest_s <= 0.0 || bus.session.play_latest_s > 1e3)
    return cli_complain("--play-latest: %g is not within 0 to 1000", bus.session.play_latest_s);
  bus.session.source.gpio = gpio_backend(backend);
  if (bus.session.source.gpio) return CLI_RUN;
  return cli_complain("--gpio-backend: '%.40s' is not in this build, which has %s", backend,
                      gpio_backend_names());
}

static enum cli_result check(int models, char **model) {
  if (!twin.truth == !bus.can) return cli_complain("expected one of --twin and --can");
  if (speed_lag_s < 0.0 || speed_lag_s > 0.1)
    return cli_complain("--speed-lag: %g is not within 0 to 0.1", speed_lag_s);
  return bus.can ? check_can(models) : check_twin(models, model);
}

/* ---- doing it --------------------------------------------------------------------- */

static int run(int models, char **model, struct app_error *error) {
  twin.drives = bus.drives = drives;
  twin.speed_lag_s = bus.speed_lag_s = speed_lag_s;
  twin.motion = bus.session.play = motion;
  bus.session.realtime = !no_realtime;
  bus.model = model[0];
  return bus.can ? loop_run(&bus, error) : comparison_run(&twin, models, model, error);
}

int main(int argc, char **argv) {
  struct app_error error;
  int first;
  enum cli_result result = cli_parse(&program, argc, argv, &first);

  if (result == CLI_RUN) result = check(argc - first, argv + first);
  if (result == CLI_DONE) return APP_OK;
  if (result == CLI_USAGE) return APP_BAD_INPUT;
  return run(argc - first, argv + first, &error) == 0 ? APP_OK : app_exit(&error);
}
