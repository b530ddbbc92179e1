/* live.c: see live.h. */
#include "live.h"

#include <errno.h>
#include <math.h>
#include <sched.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

#include "leg_bus/can_socket.h"
#include "leg_bus/lateness.h"
#include "leg_bus/leg_bus.h"
#include "leg_bus/orders.h"
#include "leg_bus/twin_states.h"
#include "talus/random.h"
#include "truth.h"

#define ZERO_STREAM 41 /* of random numbers: where the relative encoders stand at power on */
#define NS_PER_S 1000000000
#define LEAD_NS 20000000 /* from the first deadline's choice to it */
#define PRIORITY 40      /* below the threads that serve interrupts */
#define BURST 50         /* late ticks in a row; then a period's rest for those who read the bus */
#define SUPPLY_S 0.01
#define STATUS_S 0.1
#define ROOM_C 25.0
#define SUPPLY_V 24.0

struct live {
  struct twin *twin;
  tl_twin *bench;
  struct orders orders;
  struct lateness lateness;
  int fd;
  double zero_count[TL_MAX_JOINTS]; /* of the relative encoders */
  unsigned long sent, refused;
};

static volatile sig_atomic_t interrupted;

static void interrupt(int signal) {
  (void)signal;
  interrupted = 1;
}

/* ---- before ------------------------------------------------------------------------ */

static int refuse(const char *option, const char *why, struct app_error *error) {
  return app_fail(error, APP_BAD_INPUT, "--%s: not with --can: %s", option, why);
}

static int check_asked(const struct twin *t, struct app_error *error) {
  const struct twin_settings *asked = t->asked;
  const char *const model_says = "the model's bus: says how encoders count";

  if (!tl_plant_facts(t->model.plant)->leg_bus)
    return app_fail(error, APP_BAD_INPUT, "--can: only a leg has a bus");
  if (!t->has_bus)
    return app_fail(error, APP_BAD_INPUT,
                    "%s: bus: missing key, --can needs it (models/leg_bench.yaml has one)", asked->model);
  if (!isnan(asked->rate_hz))
    return refuse("rate", "each tick of the control is a sample (--control)", error);
  if (!isnan(asked->jitter_s)) return refuse("jitter", "the ticks are the samples' instants", error);
  if (!isnan(asked->ankle_bits)) return refuse("ankle-bits", model_says, error);
  for (int j = 0; j < TL_MAX_JOINTS; j++)
    if (!isnan(asked->drive_bits[j])) return refuse("encoder-bits", model_says, error);
  return 0;
}

int live_prepare(struct twin *t, struct app_error *error) {
  if (check_asked(t, error) != 0) return -1;
  twin_states_settings(&t->bus, &t->bench);
  return 0;
}

/* Real-time priority and memory that stays, where they are allowed: a twin that is late is a poor twin,
 * but no wrong one. */
static void ask_for_priority(void) {
  const struct sched_param parameter = {.sched_priority = PRIORITY};

  if (sched_setscheduler(0, SCHED_FIFO, &parameter) != 0)
    app_note("no real-time priority (%s): ticks may be late, and are counted", strerror(errno));
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0 && errno != EPERM && errno != ENOMEM)
    app_note("memory is not locked: %s", strerror(errno));
}

static void catch_signals(void) {
  struct sigaction action = {.sa_handler = interrupt};

  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, NULL);
  sigaction(SIGTERM, &action, NULL);
}

/* ---- a tick ------------------------------------------------------------------------ */

static void send_frame(struct live *l, const struct leg_bus_frame *frame) {
  if (can_socket_send(l->fd, frame) == 0)
    l->sent++;
  else
    l->refused++;
}

static void send_states(struct live *l, unsigned long tick, const double row[TL_CHANNEL_COUNT]) {
  struct leg_bus_frame frame[TL_MAX_JOINTS];

  twin_states_pack(l->bench, &l->twin->bus, (uint16_t)tick, row, l->zero_count, frame);
  for (int j = 0; j < TL_MAX_JOINTS; j++) send_frame(l, &frame[j]);
}

/* is tick one of those that come every `period_s`, and the how-manieth? */
static int is_due(const struct live *l, unsigned long tick, double period_s, uint16_t *counter) {
  const unsigned long every = (unsigned long)fmax(1.0, floor(period_s * l->bench->settings.control_hz + 0.5));

  *counter = (uint16_t)(tick / every);
  return tick % every == 0;
}

static void send_slow(struct live *l, unsigned long tick) {
  struct leg_bus_frame frame;
  uint16_t counter;

  if (is_due(l, tick, SUPPLY_S, &counter)) {
    leg_bus_pack_supply(&frame, counter, SUPPLY_V, 0.0);
    send_frame(l, &frame);
  }
  if (!is_due(l, tick, STATUS_S, &counter)) return;
  for (int j = 0; j < TL_MAX_JOINTS; j++) {
    const struct leg_bus_status status = {
        .counter = counter, .motor_C = ROOM_C, .drive_C = ROOM_C, .state = l->orders.state};
    leg_bus_pack_status(&frame, j, &status);
    send_frame(l, &frame);
  }
  leg_bus_pack_heartbeat(&frame, counter, l->lateness.over, l->orders.missed,
                         (double)tick / l->bench->settings.control_hz);
  send_frame(l, &frame);
}

static tl_status run_tick(struct live *l, unsigned long tick, double row[TL_CHANNEL_COUNT]) {
  struct leg_bus_frame frame;
  tl_status status;

  while (can_socket_receive(l->fd, &frame)) orders_take(&l->orders, &frame);
  orders_apply(&l->orders, (double)tick / l->bench->settings.control_hz, &l->twin->excitation, l->bench);
  status = tl_twin_next(l->bench, row);
  if (status != TL_OK) return status;
  send_states(l, tick, row);
  send_slow(l, tick);
  return TL_OK;
}

/* ---- all ticks --------------------------------------------------------------------- */

static int64_t now_ns(clockid_t clock) {
  struct timespec t;

  clock_gettime(clock, &t);
  return (int64_t)t.tv_sec * NS_PER_S + t.tv_nsec;
}

/* sleeps until an instant; the instant at which it awoke */
static int64_t wait_for(int64_t deadline_ns) {
  const struct timespec t = {.tv_sec = (time_t)(deadline_ns / NS_PER_S),
                             .tv_nsec = (long)(deadline_ns % NS_PER_S)};

  while (!interrupted && clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR) continue;
  return now_ns(CLOCK_MONOTONIC);
}

static tl_status run_ticks(struct live *l, struct recording_writer *writer, struct output *motion,
                           unsigned long n) {
  const double period_ns = NS_PER_S / l->bench->settings.control_hz;
  const int64_t begin_ns = now_ns(CLOCK_MONOTONIC) + LEAD_NS;
  int64_t deadline_ns, earliest_ns = 0, awake_ns;
  int late = 0;
  double row[TL_CHANNEL_COUNT];
  tl_status status = TL_OK;

  l->twin->live.begin_real_ns = now_ns(CLOCK_REALTIME) + begin_ns - now_ns(CLOCK_MONOTONIC);
  for (unsigned long tick = 0; tick < n && !interrupted; tick++) {
    deadline_ns = begin_ns + (int64_t)(period_ns * (double)tick);
    awake_ns = wait_for(deadline_ns > earliest_ns ? deadline_ns : earliest_ns);
    lateness_add(&l->lateness, awake_ns - deadline_ns, (int64_t)period_ns);
    late = awake_ns - deadline_ns > (int64_t)period_ns ? late + 1 : 0;
    earliest_ns = late > 0 && late % BURST == 0 ? awake_ns + (int64_t)period_ns : 0;
    if (interrupted) break;
    status = run_tick(l, tick, row);
    if (status != TL_OK) break;
    recording_writer_row(writer, row);
    if (motion) truth_motion_row(motion, l->bench, row[TL_CHANNEL_TIME]);
  }
  return status;
}

static void report(const struct live *l) {
  const struct orders *o = &l->orders;
  const struct lateness *late = &l->lateness;

  app_note("%lu ticks at %g Hz: late by at most %.0f us (half of them), %.0f us (99.9 %%), %.0f us (all); "
           "%lu later than a period",
           late->ticks, l->bench->settings.control_hz, lateness_quantile_us(late, 0.5),
           lateness_quantile_us(late, 0.999), (double)late->worst_ns / 1e3, late->over);
  app_note("%lu frames sent, %lu not taken by the kernel", l->sent, l->refused);
  if (o->follow)
    app_note("%lu set-points taken; %lu ticks without a new one, %lu set-points beyond a position limit",
             o->taken, o->missed, o->clamped);
  if (o->state == LEG_BUS_STOPPED) app_note("a stop frame came: the drives let go");
}

static void keep_counts(const struct live *l) {
  struct twin_live *live = &l->twin->live;

  live->ticks = l->lateness.ticks;
  live->late = l->lateness.over;
  live->worst_s = (double)l->lateness.worst_ns / NS_PER_S;
  live->sent = l->sent;
  live->refused = l->refused;
  live->setpoints = l->orders.taken;
  live->missed = l->orders.missed;
  memcpy(live->zero_count, l->zero_count, sizeof live->zero_count);
}

int live_run(struct twin *t, tl_twin *bench, struct recording_writer *writer, struct output *motion,
             struct app_error *error) {
  struct live l = {.twin = t, .bench = bench};
  tl_status status;
  double draw[2];

  l.fd = can_socket_open(t->asked->can, error);
  if (l.fd < 0) return -1;
  orders_init(&l.orders, &t->model, &t->bench, t->limits, t->asked->excitation == TWIN_BUS);
  tl_random_uniform2(t->asked->seed, ZERO_STREAM, 0, draw);
  for (int j = 0; j < TL_MAX_JOINTS; j++) l.zero_count[j] = floor(draw[j] * (UINT16_MAX + 1.0));
  catch_signals();
  ask_for_priority();
  status =
      run_ticks(&l, writer, motion, (unsigned long)floor(t->duration_s * bench->settings.sample_hz + 0.5));
  can_socket_close(l.fd);
  report(&l);
  keep_counts(&l);
  if (status != TL_OK)
    return app_fail(error, APP_FAILED, "the simulation ended after %.3f s: %s", bench->simulation.t_s,
                    tl_status_text(status));
  return 0;
}
