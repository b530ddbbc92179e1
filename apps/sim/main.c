/* talus-sim: the bench twin. A plant in forward time under the bench's position control, as a
 * recording with the answer beside it. */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "common/cli.h"
#include "common/decimal.h"
#include "common/error.h"
#include "common/output.h"
#include "twin.h"

/* ---- the command line -------------------------------------------------------------- */

static struct twin_settings asked;

/* values that are more than a number, as they were given */
static const char *excitation, *amplitude, *noise, *encoder_bits;
static uint64_t harmonics, phase_seed = UINT64_MAX;

static const struct cli_option options[] = {
    {"model", 'm', CLI_TEXT, &asked.model, 1, "TRUTH.yaml", "the plant to simulate"},
    {"out", 'o', CLI_TEXT, &asked.out, 1, "REC.csv[.gz]", "the recording to write"},
    {"truth", 0, CLI_TEXT, &asked.truth, 0, "T.json", "write true parameters, sensors and excitation"},
    {"motion", 0, CLI_TEXT, &asked.motion, 0, "M.csv",
     "write reference and true motion at the recording's samples"},
    {"excitation", 'e', CLI_TEXT, &excitation, 0, "KIND",
     "multisine (default), paper (the series (14)), ramps,\nor bus (with --can): set-points from the bus"},
    {"can", 0, CLI_TEXT, &asked.can, 0, "IFACE", "run in real time on this CAN interface (models/leg.dbc)"},
    {"reference", 0, CLI_TEXT, &asked.reference, 0, "T.csv",
     "follow this trajectory: time_s and joint angles"},
    {"period", 0, CLI_NUMBER, &asked.period_s, 0, "S", "of the series (multisine 4, paper 0.4)"},
    {"harmonics", 0, CLI_WHOLE, &harmonics, 0, "N", "of the multisine (8)"},
    {"amplitude", 0, CLI_TEXT, &amplitude, 0, "A[,B]", "of multisine or ramps at each joint [rad] or [m]"},
    {"speed", 0, CLI_NUMBER, &asked.speed, 0, "FACTOR", "move so many times as fast (1)"},
    {"limits", 0, CLI_TEXT, &asked.limits, 0, "LIST",
     "what joints can do, for instance\nknee.speed=4,ankle.position=-0.4:0.4 (and acceleration, torque)"},
    {"fit", 0, CLI_FLAG, &asked.fit, 0, NULL, "scale the excitation into the limits instead of refusing it"},
    {"duration", 'd', CLI_NUMBER, &asked.duration_s, 0, "S", "of the recording (120; ramps: their length)"},
    {"rate", 'r', CLI_NUMBER, &asked.rate_hz, 0, "HZ", "samples a second (250)"},
    {"jitter", 0, CLI_NUMBER, &asked.jitter_s, 0, "S", "of the samples' instants, up to +-S (0.0003)"},
    {"control", 0, CLI_NUMBER, &asked.control_hz, 0, "HZ", "rate of the position control (1000)"},
    {"noise", 0, CLI_TEXT, &noise, 0, "A[,B]", "standard deviation of each current [A] (leg 0.020,0.005)"},
    {"encoder-bits", 0, CLI_TEXT, &encoder_bits, 0, "N[,M]",
     "of the drives' encoders, 0 for exact (leg 14,14)"},
    {"ankle-bits", 0, CLI_NUMBER, &asked.ankle_bits, 0, "N",
     "of the ankle's absolute encoder, 0 for exact (16)"},
    {"camera", 0, CLI_FLAG, &asked.camera, 0, NULL, "record the camera's angles shank_rad and foot_rad"},
    {"camera-noise", 0, CLI_NUMBER, &asked.camera_rad, 0, "RAD", "their standard deviation (0.001)"},
    {"ideal", 0, CLI_FLAG, &asked.ideal, 0, NULL, "exact sensors, no jitter, but for what is given"},
    CLI_SEED_OPTION(&asked.seed),
    {"phase-seed", 0, CLI_WHOLE, &phase_seed, 0, "N",
     "seed of the multisine's phases alone (that of --seed)"},
};

static const struct cli_program program = {
    .name = "talus-sim",
    .summary = "simulates a bench recording of a plant, with friction that sticks, under position control",
    .example = "talus-sim --model leg.yaml --out run.csv\n"
               "talus-sim --model leg.yaml --out fast.csv --duration 20 --speed 1.3 --fit --seed 2",
    .option = options,
    .options = sizeof options / sizeof options[0],
    .more = "An excitation that breaks a limit is refused, and each limit that it breaks is named.\n"
            "The same options give the same bytes.",
};

/* ---- values -------------------------------------------------------------------- */

/* one number at *text, up to `end_with`, where *text moves behind it */
static int take_number(const char **text, char end_with, double *value) {
  const char *end;

  if (decimal_parse(*text, value, &end) != DECIMAL_OK || *end != end_with) return 0;
  *text = end + (end_with != '\0');
  return 1;
}

/* "a" or "a,b": what is not given stays */
static int take_pair(const char *text, double value[TL_MAX_JOINTS]) {
  if (!strchr(text, ',')) return take_number(&text, '\0', &value[0]);
  return take_number(&text, ',', &value[0]) && take_number(&text, '\0', &value[1]);
}

static enum cli_result read_pair(const char *name, const char *text, double value[TL_MAX_JOINTS],
                                 double high) {
  if (!text) return CLI_RUN;
  if (!take_pair(text, value))
    return cli_complain("--%s: expected a number, or two with a comma, found '%.40s'", name, text);
  for (int j = 0; j < TL_MAX_JOINTS; j++)
    if (value[j] < 0.0 || value[j] > high)
      return cli_complain("--%s: %g is not within 0 to %g", name, value[j], high);
  return CLI_RUN;
}

static enum cli_result read_excitation(void) {
  static const char *const name[] = {
      [TWIN_MULTISINE] = "multisine", [TWIN_PAPER] = "paper", [TWIN_RAMPS] = "ramps", [TWIN_BUS] = "bus"};

  for (int k = 0; excitation && k < 4; k++) {
    if (strcmp(excitation, name[k]) != 0) continue;
    asked.excitation = (enum twin_excitation)k;
    return CLI_RUN;
  }
  return excitation
             ? cli_complain(
                   "--excitation: expected multisine, paper or ramps, found '%.40s' (or bus, with --can)",
                   excitation)
             : CLI_RUN;
}

/* plain numbers against their ranges; a NaN was not given */
static enum cli_result check_numbers(void) {
  const struct {
    const char *name;
    double value, low, high;
  } number[] = {
      {"period", asked.period_s, 1e-3, 1e4},     {"speed", asked.speed, 1e-3, 1e3},
      {"duration", asked.duration_s, 1e-3, 1e6}, {"rate", asked.rate_hz, 1e-2, 1e5},
      {"jitter", asked.jitter_s, 0, 1},          {"control", asked.control_hz, 1, 1e5},
      {"ankle-bits", asked.ankle_bits, 0, 48},   {"camera-noise", asked.camera_rad, 0, 1},
  };

  for (size_t k = 0; k < sizeof number / sizeof number[0]; k++)
    if (number[k].value < number[k].low || number[k].value > number[k].high)
      return cli_complain("--%s: %g is not within %g to %g", number[k].name, number[k].value, number[k].low,
                          number[k].high);
  /* JSON's whole numbers have a sign */
  if (asked.seed > INT64_MAX) return cli_complain("--seed is at most %" PRId64, INT64_MAX);
  if (phase_seed != UINT64_MAX && phase_seed > INT64_MAX)
    return cli_complain("--phase-seed is at most %" PRId64, INT64_MAX);
  if (harmonics > TL_MAX_HARMONICS) return cli_complain("--harmonics: more than %d", TL_MAX_HARMONICS);
  return CLI_RUN;
}

/* what the chosen excitation does not know */
static enum cli_result check_excitation(void) {
  const int bus = asked.excitation == TWIN_BUS;
  const int shaped = !isnan(asked.period_s) || harmonics || amplitude || asked.speed != 1.0 || asked.fit;

  if (asked.reference && (excitation || asked.can || shaped))
    return cli_complain(
        "--reference: the motion is the file's; no --excitation, --can, --period, --harmonics, "
        "--amplitude, --speed, --fit");
  if (asked.reference) asked.excitation = TWIN_REFERENCE;
  if (bus && !asked.can) return cli_complain("--excitation bus: needs --can");
  if (bus && shaped)
    return cli_complain("--excitation bus: the motion is the bus's; no --period, --harmonics, --amplitude, "
                        "--speed, --fit");
  if (asked.excitation == TWIN_RAMPS && !isnan(asked.period_s))
    return cli_complain("--period: ramps have none");
  if (asked.excitation != TWIN_MULTISINE && harmonics)
    return cli_complain("--harmonics: for the multisine only");
  if (asked.excitation == TWIN_PAPER && amplitude)
    return cli_complain("--amplitude: the paper's series has its own");
  return CLI_RUN;
}

/* no two files in one, and none in the model's place */
static enum cli_result check_files(void) {
  const struct cli_file file[] = {{"model", asked.model},
                                  {"reference", asked.reference},
                                  {"out", asked.out},
                                  {"truth", asked.truth},
                                  {"motion", asked.motion}};

  return cli_keep_apart(file, 5);
}

static enum cli_result read_command_line(int argc, char **argv) {
  int first;
  enum cli_result result = cli_parse(&program, argc, argv, &first);

  if (result == CLI_RUN) result = read_excitation();
  if (result == CLI_RUN) result = read_pair("amplitude", amplitude, asked.amplitude, 1e3);
  if (result == CLI_RUN) result = read_pair("noise", noise, asked.noise_A, 1e6);
  if (result == CLI_RUN) result = read_pair("encoder-bits", encoder_bits, asked.drive_bits, 48);
  if (result == CLI_RUN) result = check_numbers();
  if (result == CLI_RUN) result = check_excitation();
  if (result == CLI_RUN) result = check_files();
  asked.harmonics = (int)harmonics;
  asked.phase_seed = phase_seed == UINT64_MAX ? asked.seed : phase_seed;
  return result;
}

int main(int argc, char **argv) {
  struct app_error error;
  struct twin twin;

  asked = twin_defaults();
  switch (read_command_line(argc, argv)) {
  case CLI_RUN: break;
  case CLI_DONE: return APP_OK;
  case CLI_USAGE: return APP_BAD_INPUT;
  }
  const int failed = twin_prepare(&twin, &asked, &error) != 0 || twin_run(&twin, &error) != 0;
  twin_free(&twin);
  return failed ? app_exit(&error) : APP_OK;
}
