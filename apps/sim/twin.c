/* twin.c: see twin.h. */
#include "twin.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/output.h"
#include "common/progress.h"
#include "leg_bus/orders.h"
#include "live.h"
#include "motion/limits.h"
#include "recording/recording.h"
#include "recording/recording_writer.h"
#include "reference.h"
#include "truth.h"

#define PAPER_FADE_S 2.0
#define MOST_JITTER 0.45 /* of a sample's step, as tl_twin_init */
#define SERIES_DURATION_S 120.0
#define ROUNDING_SHARE 100.0 /* a column's decimals resolve its noise or step this many times */
#define EXACT_DECIMALS 12
#define PROGRESS_ROWS 256

struct twin_settings twin_defaults(void) {
  struct twin_settings s = {.excitation = TWIN_MULTISINE,
                            .period_s = NAN,
                            .speed = 1.0,
                            .duration_s = NAN,
                            .rate_hz = NAN,
                            .jitter_s = NAN,
                            .control_hz = NAN,
                            .ankle_bits = NAN,
                            .camera_rad = NAN,
                            .seed = 1,
                            .phase_seed = 1};

  for (int j = 0; j < TL_MAX_JOINTS; j++) s.amplitude[j] = s.drive_bits[j] = s.noise_A[j] = NAN;
  return s;
}

/* ---- before the run ------------------------------------------------------------ */

static void replace(double *value, double given) {
  if (!isnan(given)) *value = given;
}

static tl_status make_multisine(struct twin *t) {
  tl_multisine_settings s = tl_multisine_defaults(&t->model);

  if (!isnan(t->asked->period_s)) s.base_hz = 1.0 / t->asked->period_s;
  if (t->asked->harmonics) s.harmonics = t->asked->harmonics;
  for (int j = 0; j < TL_MAX_JOINTS; j++) replace(&s.amplitude[j], t->asked->amplitude[j]);
  s.seed = t->asked->phase_seed;
  return tl_excitation_multisine(&t->excitation, tl_joint_count(&t->model), &s);
}

static tl_status make_ramps(struct twin *t) {
  tl_ramp_settings s = tl_ramp_defaults(&t->model);

  for (int j = 0; j < TL_MAX_JOINTS; j++) replace(&s.amplitude[j], t->asked->amplitude[j]);
  return tl_excitation_ramps(&t->excitation, tl_joint_count(&t->model), &s);
}

static tl_status make_paper(struct twin *t) {
  tl_status status = tl_excitation_paper(&t->excitation, tl_joint_count(&t->model));

  t->excitation.fade_s = PAPER_FADE_S;
  if (!isnan(t->asked->period_s)) t->excitation.base_hz = 1.0 / t->asked->period_s;
  return status;
}

static tl_status make_excitation(struct twin *t) {
  tl_status status = TL_OK;

  switch (t->asked->excitation) {
  case TWIN_MULTISINE: status = make_multisine(t); break;
  case TWIN_PAPER: status = make_paper(t); break;
  case TWIN_RAMPS: status = make_ramps(t); break;
  case TWIN_BUS: orders_rest(&t->excitation, tl_joint_count(&t->model)); return TL_OK;
  case TWIN_REFERENCE: reference_rest(&t->trajectory, &t->excitation); return TL_OK;
  }
  if (status == TL_OK) tl_excitation_speed_up(&t->excitation, t->asked->speed);
  return status;
}

static double step_of_bits(double bits) {
  return bits > 0.0 ? 2.0 * acos(-1.0) / exp2(bits) : 0.0;
}

/* the bench's settings: its defaults, exact sensors if so asked, then what was given */
static void make_bench(struct twin *t) {
  const struct twin_settings *asked = t->asked;
  tl_twin_settings *s = &t->bench;

  *s = tl_twin_defaults(&t->model, &t->excitation);
  if (asked->ideal) s->jitter_s = s->ankle_step_rad = s->camera_noise_rad = 0.0;
  for (int j = 0; j < TL_MAX_JOINTS; j++) {
    if (asked->ideal) s->drive_step_rad[j] = s->current_noise_A[j] = 0.0;
    if (!isnan(asked->drive_bits[j])) s->drive_step_rad[j] = step_of_bits(asked->drive_bits[j]);
    replace(&s->current_noise_A[j], asked->noise_A[j]);
  }
  if (!isnan(asked->ankle_bits)) s->ankle_step_rad = step_of_bits(asked->ankle_bits);
  replace(&s->camera_noise_rad, asked->camera_rad);
  replace(&s->jitter_s, asked->jitter_s);
  replace(&s->sample_hz, asked->rate_hz);
  replace(&s->control_hz, asked->control_hz);
  for (int j = 0; asked->camera && j < tl_joint_count(&t->model); j++)
    s->channels |= TL_CHANNEL_BIT(tl_plant_facts(t->model.plant)->sensors.camera[j]);
  s->seed = asked->seed;
  s->effect = t->effect;
  s->effects = t->effects;
}

static const char *unit_of(const tl_model *m, tl_quantity quantity, char text[16]) {
  static const char *const per_time[TL_QUANTITIES] = {
      [TL_QUANTITY_SPEED] = "/s", [TL_QUANTITY_ACCELERATION] = "/s^2"};
  const tl_facts *f = tl_plant_facts(m->plant);

  if (quantity == TL_QUANTITY_TORQUE) return f->torque_unit;
  snprintf(text, 16, "%s%s", f->coordinate_unit, per_time[quantity] ? per_time[quantity] : "");
  return text;
}

/* one line with every limit that is broken */
static int report_broken(const struct twin *t, const tl_peak *peak, int n, struct app_error *error) {
  char list[900];
  size_t length = 0;

  for (int i = 0; i < n && length < sizeof list; i++) {
    char text[16];
    const char *unit = unit_of(&t->model, peak[i].quantity, text);
    length += (size_t)snprintf(list + length, sizeof list - length,
                               "%s%s %s %.4g %s at %.3f s (limit %.4g, %.3g beyond)", i ? "; " : "",
                               tl_joint_name(&t->model, peak[i].joint), tl_quantity_name(peak[i].quantity),
                               peak[i].peak, unit, peak[i].t_s, peak[i].limit, peak[i].excess);
  }
  return app_fail(error, APP_BAD_INPUT, "the excitation breaks %d limit%s: %s%s", n, n == 1 ? "" : "s", list,
                  t->asked->reference ? "" : "; --fit would scale it");
}

static int fit_excitation(struct twin *t, struct app_error *error) {
  tl_status status = tl_excitation_fit(&t->model, t->limits, &t->excitation, &t->scaling);

  if (status == TL_ERR_RANGE)
    return app_fail(error, APP_BAD_INPUT,
                    "--fit: the middle of the excitation lies outside the position limits");
  if (status == TL_ERR_NO_CONVERGENCE)
    return app_fail(error, APP_BAD_INPUT, "--fit: gravity and friction alone break the torque limit");
  if (status != TL_OK) return app_fail(error, APP_FAILED, "--fit: %s", tl_status_text(status));
  for (int j = 0; j < tl_joint_count(&t->model); j++)
    if (t->scaling.amplitude[j] < 1.0)
      app_note("%s: amplitude times %.4f to fit the position limits", tl_joint_name(&t->model, j),
               t->scaling.amplitude[j]);
  if (t->scaling.speed < 1.0)
    app_note("speed times %.4f to fit the limits on speed, acceleration and torque", t->scaling.speed);
  return 0;
}

static int keep_limits(struct twin *t, struct app_error *error) {
  tl_peak peak[TL_MAX_PEAKS];
  int broken;

  tl_twin_limits(&t->model, &t->bench, t->limits);
  if (t->asked->limits && limits_read(t->asked->limits, &t->model, t->limits, error) != 0) return -1;
  if (t->asked->reference) {
    broken = reference_check(&t->model, t->limits, &t->trajectory, peak);
    return broken ? report_broken(t, peak, broken, error) : 0;
  }
  if (t->asked->fit) return fit_excitation(t, error);
  if (tl_excitation_check(&t->model, t->limits, &t->excitation, peak, &broken) != TL_OK)
    return app_fail(error, APP_FAILED, "the excitation is not for this plant");
  return broken ? report_broken(t, peak, broken, error) : 0;
}

/* is what was asked for something that this plant has? */
static int check_plant(const struct twin *t, struct app_error *error) {
  if (t->asked->camera && tl_plant_facts(t->model.plant)->sensors.camera[0] == TL_NO_CHANNEL)
    return app_fail(error, APP_BAD_INPUT, "--camera: only a leg has camera angles");
  return 0;
}

/* rates and duration against each other */
static int check_times(const struct twin *t, struct app_error *error) {
  const tl_twin_settings *s = &t->bench;

  if (s->sample_hz > s->control_hz)
    return app_fail(error, APP_BAD_INPUT, "--rate: %g Hz is above the control's %g Hz", s->sample_hz,
                    s->control_hz);
  if (s->jitter_s > MOST_JITTER / s->sample_hz)
    return app_fail(error, APP_BAD_INPUT, "--jitter: %g s is more than %g of a sample's step", s->jitter_s,
                    MOST_JITTER);
  if (t->duration_s * s->sample_hz < RECORDING_MIN_ROWS)
    return app_fail(error, APP_BAD_INPUT, "--duration: %g s are fewer than %d samples", t->duration_s,
                    RECORDING_MIN_ROWS);
  return 0;
}

/* are there effects that this bench cannot show? */
static int check_effects(const struct twin *t, struct app_error *error) {
  for (int i = 0; i < t->effects; i++) {
    const tl_effect_kind *kind = t->effect[i].kind;
    if (kind->needs_load_sensor)
      return app_fail(error, APP_BAD_INPUT,
                      "%s: effects: '%s' shows only at a torque sensor at the output, "
                      "which this bench does not have",
                      t->asked->model, kind->name);
    const int recorded = tl_effect_fit_only(&t->effect[i]);
    if (recorded >= 0)
      return app_fail(error, APP_BAD_INPUT,
                      "%s: effects: '%s' is not simulated with this %s, recordings alone can show it",
                      t->asked->model, kind->name, kind->parameter[recorded].name);
    if (t->model.form == TL_FORM_PAPER)
      return app_fail(error, APP_BAD_INPUT, "%s: effects: `form: paper` takes none in forward time",
                      t->asked->model);
  }
  return 0;
}

static int read_reference(struct twin *t, struct app_error *error) {
  if (trajectory_read(t->asked->reference, &t->model, NULL, &t->trajectory, error) != 0) return -1;
  if (trajectory_orders_drives(&t->trajectory))
    app_note("%s: the simulated bench follows the angles; speeds and torques are not used",
             t->asked->reference);
  return 0;
}

int twin_prepare(struct twin *twin, const struct twin_settings *settings, struct app_error *error) {
  struct model_file file;

  memset(twin, 0, sizeof *twin);
  twin->asked = settings;
  twin->scaling = (tl_scaling){{1.0, 1.0}, 1.0};
  if (model_file_read(settings->model, &file, error) != 0) return -1;
  twin->model = file.model;
  memcpy(twin->effect, file.effect, sizeof twin->effect);
  twin->effects = file.effects;
  twin->bus = file.bus;
  twin->has_bus = file.has_bus;
  if (check_plant(twin, error) != 0 || check_effects(twin, error) != 0) return -1;
  if (settings->reference && read_reference(twin, error) != 0) return -1;
  if (make_excitation(twin) != TL_OK)
    return app_fail(error, APP_BAD_INPUT,
                    "excitation: --period, --harmonics (1 to %d), --amplitude or --speed out of range",
                    TL_MAX_HARMONICS);
  make_bench(twin);
  if (keep_limits(twin, error) != 0) return -1;
  make_bench(twin); /* slower means longer to settle */
  if (settings->can && live_prepare(twin, error) != 0) return -1;
  twin->duration_s =
      settings->excitation == TWIN_RAMPS ? tl_excitation_length_s(&twin->excitation) : SERIES_DURATION_S;
  if (settings->reference) twin->duration_s = trajectory_length_s(&twin->trajectory);
  replace(&twin->duration_s, settings->duration_s);
  return check_times(twin, error);
}

/* ---- the files ------------------------------------------------------------------- */

/* decimals that resolve `fine`, a step or a standard deviation */
static int decimals_for(double fine) {
  double places = ceil(log10(ROUNDING_SHARE / fine) - 1e-9);

  return fine > 0.0 && places < EXACT_DECIMALS ? (places > 0.0 ? (int)places : 0) : EXACT_DECIMALS;
}

static void choose_decimals(const struct twin *t, int decimals[TL_CHANNEL_COUNT + 1]) {
  const tl_sensors *of = &tl_plant_facts(t->model.plant)->sensors;
  const tl_twin_settings *s = &t->bench;

  for (int c = 0; c <= TL_CHANNEL_COUNT; c++) decimals[c] = EXACT_DECIMALS;
  for (int j = 0; j < tl_joint_count(&t->model); j++) {
    const double noise_A = s->current_noise_A[j];
    decimals[of->position[j]] = decimals[of->command[j]] = decimals_for(s->drive_step_rad[j]);
    decimals[of->encoder[j]] = decimals_for(s->ankle_step_rad);
    decimals[of->camera[j]] = decimals_for(s->camera_noise_rad);
    decimals[of->current[j]] = decimals_for(noise_A);
    decimals[of->torque[j]] = decimals_for(noise_A * fabs(tl_torque_per_current(&t->model, j, 0.0)));
  }
  decimals[TL_CHANNEL_TIME] = decimals_for(s->clock_s * ROUNDING_SHARE);
}

/* ---- the run --------------------------------------------------------------------- */

static int at_limit(const tl_twin *b) {
  for (int j = 0; j < tl_joint_count(b->model); j++)
    if (fabs(b->current_A[j]) >= b->settings.current_limit_A[j]) return 1;
  return 0;
}

/* all samples into the two files; motion may be NULL */
static int run_samples(struct twin *t, tl_twin *bench, struct recording_writer *writer, struct output *motion,
                       struct app_error *error) {
  unsigned long n = (unsigned long)floor(t->duration_s * t->bench.sample_hz + 0.5), limited = 0;
  double row[TL_CHANNEL_COUNT];
  struct progress progress;
  tl_status status = TL_OK;

  progress_begin(&progress, "simulating", NULL);
  for (unsigned long k = 0; k < n; k++) {
    if (t->asked->reference) reference_lay(&t->trajectory, bench, &t->excitation);
    status = tl_twin_next(bench, row);
    if (status != TL_OK) break;
    recording_writer_row(writer, row);
    if (motion) truth_motion_row(motion, bench, row[TL_CHANNEL_TIME]);
    limited += (unsigned long)at_limit(bench);
    if (k % PROGRESS_ROWS == 0) progress_update(&progress, (double)k / (double)n);
  }
  progress_end(&progress);
  if (status != TL_OK)
    return app_fail(error, APP_FAILED, "the simulation ended after %.3f s: %s", bench->simulation.t_s,
                    tl_status_text(status));
  if (limited)
    app_note("a drive was at its current limit in %.2f %% of the samples",
             100.0 * (double)limited / (double)n);
  return 0;
}

static int run(struct twin *t, tl_twin *bench, struct recording_writer *writer, struct output *motion,
               struct app_error *error) {
  if (t->asked->can) return live_run(t, bench, writer, motion, error);
  return run_samples(t, bench, writer, motion, error);
}

int twin_run(struct twin *twin, struct app_error *error) {
  int decimals[TL_CHANNEL_COUNT + 1], result = -1;
  struct recording_writer *writer = NULL;
  struct output *motion = NULL;
  tl_twin bench;
  tl_status status = tl_twin_init(&bench, &twin->model, &twin->excitation, &twin->bench);

  if (status == TL_ERR_UNSUPPORTED)
    return app_fail(error, APP_BAD_INPUT,
                    "%s: `form: paper` with Coulomb friction has no motion in forward time",
                    twin->asked->model);
  if (status != TL_OK)
    return app_fail(error, APP_BAD_INPUT, "the bench cannot be built: %s", tl_status_text(status));
  choose_decimals(twin, decimals);
  writer = recording_writer_open(twin->asked->out, twin->bench.channels, decimals, error);
  if (!writer) return -1;
  if (twin->asked->motion) {
    motion = output_open(twin->asked->motion, error);
    if (motion) truth_motion_header(motion, &twin->model);
  }
  if (!twin->asked->motion || motion) result = run(twin, &bench, writer, motion, error);
  if (result == 0 && twin->asked->truth) result = truth_write(twin, &bench, error);
  if (result != 0) {
    output_abandon(motion);
    recording_writer_abandon(writer);
    return -1;
  }
  if (motion) result = output_commit(motion, error);
  if (result == 0) return recording_writer_commit(writer, error);
  recording_writer_abandon(writer);
  return -1;
}

void twin_free(struct twin *twin) {
  trajectory_free(&twin->trajectory);
}
