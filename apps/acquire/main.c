/* talus-acquire: records CAN interfaces and GPIO lines, with the kernel's times, and says what was lost. */
#define _GNU_SOURCE

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "acquire/host/qualify.h"
#include "acquire/info/info.h"
#include "acquire/record/session.h"
#include "common/cli.h"
#include "common/error.h"
#include "common/output.h"

static struct session_settings asked = {
    .realtime = 1, .play_latest_s = 0.05, .source = {.receive_bytes = RECEIVE_BYTES}};
static const char *backend;
static int no_realtime, qualify;
static const char *report, *rotate;
static const double QUALIFY_S = 300.0; /* without --duration */

static const struct cli_option options[] = {
    {"out", 'o', CLI_TEXT, &asked.out, 0, "REC[.log]",
     "write REC.log (frames) and REC.jsonl (all else); required"},
    {"duration", 'd', CLI_NUMBER, &asked.duration_s, 0, "S", "end after S seconds (else Ctrl-C ends)"},
    {"overwrite", 0, CLI_FLAG, &asked.overwrite, 0, NULL, "replace files of that name"},
    {"rotate", 0, CLI_TEXT, &rotate, 0, "SIZE|TIME",
     "begin the next file, REC.001.log and so on, after so much\n(100M, 2G) or so long (15min, 1h)"},
    {"compress", 0, CLI_FLAG, &asked.compress, 0, NULL,
     "--rotate's files that are full become REC.log.gz and so on"},
    {"quiet", 'q', CLI_FLAG, &asked.quiet, 0, NULL, "no live line, no summary"},
    {"stop", 0, CLI_TEXT, &asked.stop, 0, "IF[:ID#DATA]",
     "what an emergency edge sends on interface IF\n(the Stop frame of models/leg.dbc, or ID#DATA), three "
     "times"},
    {"play", 0, CLI_TEXT, &asked.play, 0, "TRAJ.csv", "send the set-points of a trajectory at their times"},
    {"play-on", 0, CLI_TEXT, &asked.play_on, 0, "IF", "the interface to send them on (the first CAN source)"},
    {"limits", 0, CLI_TEXT, &asked.limits, 0, "LIST",
     "what the joints can do, checked before the first set-point,\nfor instance "
     "knee.position=-0.9:0.1,knee.speed=4 (and acceleration, torque)"},
    {"play-latest", 0, CLI_NUMBER, &asked.play_latest_s, 0, "S",
     "a set-point later than S ends the playing (0.05)"},
    {"qualify", 0, CLI_FLAG, &qualify, 0, NULL,
     "judge this machine for five minutes (or --duration),\nwhile the sources, if any, are recorded"},
    {"report", 0, CLI_TEXT, &report, 0, "Q.json", "--qualify's verdicts as JSON too"},
    {"buffer", 0, CLI_WHOLE, &asked.source.receive_bytes, 0, "BYTES", "of each socket (4194304)"},
    {"software-stamps", 0, CLI_FLAG, &asked.source.software_stamps, 0, NULL,
     "the kernel's stamps even where the adapter has a clock"},
    {"no-realtime", 0, CLI_FLAG, &no_realtime, 0, NULL, "ask for no priority and no locked memory"},
    {"gpio-backend", 0, CLI_TEXT, &backend, 0, "NAME",
     "kernel (default), or libgpiod1 or libgpiod2 where built in"},
};

static const struct cli_program program = {
    .name = "talus-acquire",
    .summary = "records CAN interfaces and GPIO lines; loses nothing, or says what was lost and where",
    .example = "talus-acquire --out walk can0 gpio:camera=gpiochip0:3:rising\n"
               "talus-acquire --out walk --duration 120 --stop can0 can0 estop:button=gpiochip0:4\n"
               "talus-acquire info walk.log",
    .arguments = "SOURCE...",
    .min_arguments = 0,
    .max_arguments = MAX_SOURCES,
    .option = options,
    .options = sizeof options / sizeof options[0],
    .more = "SOURCE is one of\n"
            "  can0                               a CAN interface, classic and FD\n"
            "  gpio:NAME=CHIP:LINE[:EDGES][:PULL] edges of a line; rising, falling, both (default);\n"
            "                                     pull-up, pull-down\n"
            "  estop:NAME=CHIP:LINE[:EDGES]       the same, and each edge (falling) sends --stop's frame\n"
            "  pulse:NAME=CHIP:LINE:HZ[:MS]       drives a line, for a camera or an LED\n"
            "  fd:NAME=N                          frames from an inherited socket\n"
            "\n"
            "talus-acquire info REC.log: what a record holds, its gaps, clocks and rates.\n"
            "talus-acquire export --help: a record to a recording in CSV.",
};

/* ---- the command line ------------------------------------------------------------- */

static enum cli_result check_numbers(void) {
  if (asked.duration_s < 0.0 || asked.duration_s > 1e7)
    return cli_complain("--duration: %g is not within 0 to 1e7", asked.duration_s);
  if (asked.play_latest_s <= 0.0 || asked.play_latest_s > 1e3)
    return cli_complain("--play-latest: %g is not within 0 to 1000", asked.play_latest_s);
  if (asked.source.receive_bytes < 4096 || asked.source.receive_bytes > 1 << 30)
    return cli_complain("--buffer: expected 4096 to %d", 1 << 30);
  if (rotate && series_limit_parse(rotate, &asked.divide) != 0)
    return cli_complain(
        "--rotate: expected a size from 4k on (k, M, G) or a time from 1s on (s, min, h), found '%.40s'",
        rotate);
  if (asked.compress && !rotate) return cli_complain("--compress goes with --rotate");
  return CLI_RUN;
}

/* what is missing, unless the machine alone is judged */
static enum cli_result check_purpose(int sources) {
  if (report && !qualify) return cli_complain("--report goes with --qualify");
  if (report && output_same(report, asked.out ? asked.out : ""))
    return cli_complain("--report and --out are one file");
  if (qualify && !sources && asked.out) return cli_complain("SOURCE... is missing: --out would stay empty");
  if (qualify && !sources) return asked.play ? cli_complain("--play needs a SOURCE...") : CLI_RUN;
  if (!asked.out) return cli_complain("--out REC[.log] is missing");
  return sources ? CLI_RUN : cli_complain("SOURCE... is missing");
}

static enum cli_result read_command_line(int argc, char **argv, int *first) {
  enum cli_result result = cli_parse(&program, argc, argv, first);
  if (result == CLI_RUN) result = check_numbers();
  if (result == CLI_RUN) result = check_purpose(argc - *first);
  if (result != CLI_RUN) return result;
  asked.realtime = !no_realtime;
  asked.source.gpio = gpio_backend(backend);
  if (!asked.source.gpio)
    return cli_complain("--gpio-backend: '%.40s' is not in this build, which has %s", backend,
                        gpio_backend_names());
  return CLI_RUN;
}

static int parse_sources(int n, char **text, struct source_spec *spec, struct app_error *error) {
  int stops = 0;
  for (int i = 0; i < n; i++) {
    if (source_spec_parse(text[i], &spec[i], error) != 0) return -1;
    stops += spec[i].kind == SOURCE_ESTOP;
  }
  for (int i = 0; i < n && !asked.play_on; i++)
    if (spec[i].kind == SOURCE_CAN) asked.play_on = spec[i].name;
  if (asked.play && (!asked.play_on || !asked.limits))
    return app_fail(error, APP_BAD_INPUT, "--play needs %s",
                    asked.limits ? "a CAN source or --play-on" : "--limits");
  if (stops && !asked.stop) return app_fail(error, APP_BAD_INPUT, "an estop source needs --stop");
  return 0;
}

/* ---- doing it --------------------------------------------------------------------- */

/* the recording that the options ask for; -1 and the error when something was lost, or nothing could be done */
static int record(int sources, char **text, struct session *session, struct app_error *error) {
  static struct source_spec spec[MAX_SOURCES];
  if (parse_sources(sources, text, spec, error) != 0) return -1;
  asked.source.stop = &session->stop_line;
  int result = session_open(session, &asked, spec, sources, error);
  if (result == 0) result = session_run(session, error);
  session_close(session);
  return result;
}

static struct session recording; /* large, and there is one */

static int record_only(int sources, char **text) {
  struct app_error error;
  return record(sources, text, &recording, &error) == 0 ? APP_OK : app_exit(&error);
}

static int judge_machine(int sources, char **text) {
  static struct qualify q;
  struct app_error error, lost;
  int status = APP_OK;
  if (report && output_probe(report, &error) != 0) return app_exit(&error);
  if (asked.duration_s == 0.0) asked.duration_s = QUALIFY_S;
  if (qualify_begin(&q, asked.realtime, &error) != 0) return app_exit(&error);
  if (!sources) qualify_wait(&q, asked.duration_s);
  if (sources && record(sources, text, &recording, &lost) != 0) status = app_exit(&lost);
  if (status == APP_BAD_INPUT) return status;
  const struct session_result result = session_result(&recording);
  const struct qualify_recording seen = {result.sources, result.lost, result.lost_is_all, result.loop};
  qualify_end(&q, sources ? &seen : NULL);
  qualify_print(&q);
  if (report && qualify_write(&q, report, &error) != 0) return app_exit(&error);
  return status;
}

/* the export is a program of its own beside this one */
static int export(char **argv) {
  char path[4096];
  struct app_error error;
  const ssize_t n = readlink("/proc/self/exe", path, sizeof path - sizeof "-export");
  app_set_name(program.name);
  if (n <= 0) {
    app_fail(&error, APP_FAILED, "export: this program's folder is not known");
    return app_exit(&error);
  }
  memcpy(path + n, "-export", sizeof "-export");
  argv[1] = path;
  execv(path, argv + 1);
  app_fail(&error, APP_FAILED, "%s cannot be run (`make` builds it)", path);
  return app_exit(&error);
}

int main(int argc, char **argv) {
  int first;
  if (argc > 1 && strcmp(argv[1], "export") == 0) return export(argv);
  if (argc > 1 && strcmp(argv[1], "info") == 0) return info_main(argc - 1, argv + 1);
  switch (read_command_line(argc, argv, &first)) {
  case CLI_RUN:
    return qualify ? judge_machine(argc - first, argv + first) : record_only(argc - first, argv + first);
  case CLI_DONE: return APP_OK;
  case CLI_USAGE: break;
  }
  return APP_BAD_INPUT;
}
