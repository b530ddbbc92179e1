/* player.c: frames at absolute instants. */
#define _GNU_SOURCE

#include "player.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "acquire/host/clocks.h"

enum { HEARTBEAT_NS = 10000000, RETRY_NS = 100000, HOLD_TRIED_NS = 500000000, NS_PER_S = 1000000000 };

/* ---- before the start --------------------------------------------------------------------- */

static struct can_frame frame_of(const struct leg_bus_frame *from) {
  struct can_frame frame;
  memset(&frame, 0, sizeof frame);
  frame.can_id = from->id;
  frame.can_dlc = from->length;
  memcpy(frame.data, from->data, sizeof from->data);
  return frame;
}

static struct can_frame heartbeat_of(uint16_t counter, enum leg_bus_mode mode) {
  struct leg_bus_frame frame;
  memset(&frame, 0, sizeof frame);
  leg_bus_host_heartbeat(&frame, counter, mode);
  return frame_of(&frame);
}

static int make_frames(struct player *p, struct app_error *error) {
  const struct trajectory *t = &p->points;
  p->frame = calloc(t->rows * SETPOINT_JOINTS, sizeof *p->frame);
  if (!p->frame) return app_fail(error, APP_FAILED, "out of memory");
  for (size_t i = 0; i < t->rows; i++)
    for (int j = 0; j < SETPOINT_JOINTS; j++) {
      struct leg_bus_frame frame;
      memset(&frame, 0, sizeof frame);
      if (leg_bus_command(&frame, j, (uint16_t)i, t->q[j][i], trajectory_speed(t, i, j),
                          trajectory_torque(t, i, j)) != 0)
        return app_fail(error, APP_BAD_INPUT,
                        "%s: time_s %.6g: a set-point does not fit into its field: nothing is sent", t->path,
                        t->begin_s + t->t_s[i]);
      p->frame[i * SETPOINT_JOINTS + (size_t)j] = frame_of(&frame);
    }
  return 0;
}

/* a feed's rows are its own: those of the file may be as far apart as they like */
static int read_points(struct player *p, const char *file, struct app_error *error) {
  static const tl_model leg = {.plant = TL_PLANT_LEG};
  if (!p->feed) return setpoints_read(&p->points, file, error);
  if (trajectory_read(file, &leg, NULL, &p->points, error) != 0) return -1;
  return trajectory_resample(&p->points, p->feed->step_s, p->feed->rest_s, error);
}

int player_open(struct player *p, const char *file, const char *limits, const char *interface,
                const struct player_feed *feed, struct app_error *error) {
  tl_limits allowed[SETPOINT_JOINTS];
  memset(p, 0, sizeof *p);
  p->feed = feed;
  p->port.fd = -1;
  if (setpoints_limits(limits, allowed, error) != 0) return -1;
  if (read_points(p, file, error) != 0) return -1;
  if (setpoints_check(&p->points, allowed, error) != 0 || make_frames(p, error) != 0) return -1;
  const int failure = can_port_open(&p->port, interface);
  if (failure == ENODEV) return app_fail(error, APP_BAD_INPUT, "--play-on: %s: no such interface", interface);
  return failure ? app_fail(error, APP_FAILED, "--play-on: %s: %s", interface, strerror(failure)) : 0;
}

void player_close(struct player *p) {
  can_port_close(&p->port);
  free(p->frame);
  p->frame = NULL;
  trajectory_free(&p->points);
}

/* ---- the loop ------------------------------------------------------------------------------- */

static int stopped(const struct player *p) {
  return __atomic_load_n(&p->stop, __ATOMIC_ACQUIRE);
}

static int is_full(int failure) {
  return failure == ENOBUFS || failure == EAGAIN || failure == EINTR;
}

/* a full transmit queue is waited for, but not longer than a set-point is worth */
static int send_by(struct player *p, const struct can_frame *frame, int64_t latest_ns) {
  while (!stopped(p)) {
    const int failure = can_port_send(&p->port, frame);
    if (!failure) return 0;
    if (!is_full(failure) || clock_mono_ns() > latest_ns) break;
    p->refused++;
    clock_sleep_until(clock_mono_ns() + RETRY_NS);
  }
  return -1;
}

/* made before the start, or now */
static int feed_row(struct player *p, size_t i) {
  struct leg_bus_frame frame[SETPOINT_JOINTS];
  if (!p->feed) return 0;
  memset(frame, 0, sizeof frame);
  if (p->feed->row(p->feed->context, i, frame) != 0) return -1;
  for (int j = 0; j < SETPOINT_JOINTS; j++) p->frame[i * SETPOINT_JOINTS + (size_t)j] = frame_of(&frame[j]);
  return 0;
}

static enum player_end play_row(struct player *p, size_t i, int64_t due_ns) {
  const int64_t late_ns = clock_mono_ns() - due_ns;
  if (late_ns > p->latest_ns) return PLAYER_TOO_LATE;
  if (feed_row(p, i) != 0) return PLAYER_NO_FIELD;
  lateness_add(&p->late, late_ns, NS_PER_S);
  for (int j = 0; j < SETPOINT_JOINTS; j++)
    if (send_by(p, &p->frame[i * SETPOINT_JOINTS + (size_t)j], due_ns + p->latest_ns) != 0)
      return stopped(p) ? PLAYER_STOPPED : PLAYER_REFUSED;
  p->rows_sent++;
  return PLAYER_RUNS;
}

static void beat(struct player *p, uint16_t counter, enum leg_bus_mode mode) {
  p->heartbeat = heartbeat_of(counter, mode);
  if (can_port_send(&p->port, &p->heartbeat) != 0) p->refused++;
}

/* the last word must arrive: an interface that is full, or down for a moment, is tried again */
static void hold(struct player *p, uint16_t counter) {
  const int64_t until_ns = clock_mono_ns() + HOLD_TRIED_NS;
  p->heartbeat = heartbeat_of(counter, LEG_BUS_HOLD);
  while ((p->hold_failure = can_port_send(&p->port, &p->heartbeat)) != 0 && clock_mono_ns() < until_ns)
    clock_sleep_until(clock_mono_ns() + HEARTBEAT_NS);
}

void player_run(struct player *p) {
  const struct trajectory *t = &p->points;
  enum player_end end = PLAYER_RUNS;
  int64_t next_beat_ns = p->start_ns - HEARTBEAT_NS;
  uint16_t beats = 0;
  for (size_t i = 0; i < t->rows && end == PLAYER_RUNS; i++) {
    const int64_t due_ns = p->start_ns + llround(t->t_s[i] * NS_PER_S);
    for (; next_beat_ns <= due_ns; next_beat_ns += HEARTBEAT_NS) {
      clock_sleep_until(next_beat_ns);
      if (!stopped(p)) beat(p, beats++, LEG_BUS_FOLLOW);
    }
    clock_sleep_until(due_ns);
    end = stopped(p) ? PLAYER_STOPPED : play_row(p, i, due_ns);
  }
  hold(p, beats);
  __atomic_store_n(&p->end, end == PLAYER_RUNS ? PLAYER_DONE : (int)end, __ATOMIC_RELEASE);
}

/* ---- afterwards ------------------------------------------------------------------------------- */

const char *player_end_text(const struct player *p) {
  static const char *const text[] = {"running",
                                     "done",
                                     "stopped",
                                     "too late",
                                     "refused by the kernel",
                                     "a set-point that does not fit into its field"};
  return text[p->end];
}

void player_report(const struct player *p, struct text *json) {
  text_begin(json, "play");
  text_set_string(json, "file", p->points.path);
  text_set_string(json, "end", player_end_text(p));
  text_set(json, "mono_ns", p->start_ns);
  text_set(json, "rows", (int64_t)p->points.rows);
  text_set(json, "sent", (int64_t)p->rows_sent);
  text_set_bool(json, "held", p->hold_failure == 0);
  text_set(json, "waited_for_room", (int64_t)p->refused);
  text_set(json, "worst_late_ns", p->late.worst_ns);
  text_key(json, "late_below_us");
  text_string(json, "{");
  const char *comma = "\"";
  for (int k = 0; k < LATENESS_CLASSES; k++) {
    if (!p->late.count[k]) continue;
    text_string(json, comma);
    text_whole(json, (int64_t)1 << k);
    text_string(json, "\":");
    text_whole(json, (int64_t)p->late.count[k]);
    comma = ",\"";
  }
  text_string(json, "}");
  text_end(json);
  if (p->feed) p->feed->report(p->feed->context, json);
}

void player_print(const struct player *p) {
  fprintf(stderr, "  played %zu of %zu set-points (%s); late by\n", p->rows_sent, p->points.rows,
          player_end_text(p));
  for (int k = 0; k < LATENESS_CLASSES; k++)
    if (p->late.count[k]) fprintf(stderr, "    below %8.0f us  %9lu\n", ldexp(1.0, k), p->late.count[k]);
  fprintf(stderr, "    worst %10.1f us\n", 1e-3 * (double)p->late.worst_ns);
  if (p->feed) p->feed->print(p->feed->context);
}
