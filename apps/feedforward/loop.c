/* loop.c: see loop.h. The session's player wakes up at each tick and asks for its frames; this makes them from what the
 * bus has brought since. */
#include "loop.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "feed.h"
#include "leg_bus/can_socket.h"

#define FALL_TICKS 100 /* before the end torque goes to zero: the drives hold by themselves then */

struct loop {
  const struct loop_settings *settings;
  struct model_file file;
  struct controller controller;
  struct session session; /* large */
  struct player_feed hook;
  struct feed feed;
  int fd; /* states and stops */
};

/* ---- a tick ------------------------------------------------------------------------ */

static void receive(struct loop *l) {
  const int first = l->feed.ticks == 0; /* what has waited since the socket was opened is old */
  struct leg_bus_frame frame;

  while (can_socket_receive(l->fd, &frame))
    if (!first || leg_bus_is_stop(&frame)) feed_take(&l->feed, &frame);
}

static int make_row(void *context, size_t row, struct leg_bus_frame frame[SETPOINT_JOINTS]) {
  struct loop *l = context;
  const struct trajectory *t = &l->session.player.points;
  double torque_Nm[TL_CONTROLLER_JOINTS];
  tl_motion to;

  receive(l);
  feed_tick(&l->feed, t->t_s[row], row + FALL_TICKS < t->rows, &to, torque_Nm);
  for (int j = 0; j < TL_CONTROLLER_JOINTS; j++)
    if (leg_bus_command(&frame[j], j, (uint16_t)row, to.q[j], to.v[j], torque_Nm[j]) != 0) return -1;
  return 0;
}

/* ---- afterwards -------------------------------------------------------------------- */

static void report(const void *context, struct text *json) {
  const struct loop *l = context;
  const struct feed *f = &l->feed;

  text_begin(json, "feedforward");
  text_set_string(json, "model", l->settings->model);
  text_set(json, "ticks", (int64_t)f->ticks);
  text_set(json, "measured", (int64_t)f->frames);
  text_set(json, "knee_peak_uNm", (int64_t)(1e6 * f->peak_Nm[0] + 0.5));
  text_set(json, "ankle_peak_uNm", (int64_t)(1e6 * f->peak_Nm[1] + 0.5));
  text_set_bool(json, "stop_frame", f->stopped);
  for (int bit = 0; bit < FEED_STATUS_BITS; bit++)
    text_set(json, feed_status_name(bit), (int64_t)f->told[bit]);
  text_end(json);
}

static void print(const void *context) {
  const struct loop *l = context;
  const struct feed *f = &l->feed;

  fprintf(stderr,
          "  feedforward of %s: %lu ticks, %lu measured; at most %.4f Nm at the knee's motor, %.4f Nm at the "
          "ankle's\n",
          l->settings->model, f->ticks, f->frames, f->peak_Nm[0], f->peak_Nm[1]);
  for (int bit = 0; bit < FEED_STATUS_BITS; bit++)
    if (f->told[bit]) fprintf(stderr, "    %-16s %9lu ticks\n", feed_status_name(bit), f->told[bit]);
}

/* ---- before ------------------------------------------------------------------------ */

static int read_model(struct loop *l, struct app_error *error) {
  const struct loop_settings *s = l->settings;

  if (model_file_read(s->model, &l->file, error) != 0) return -1;
  if (controller_make(&l->file, s->model, &s->drives, &l->controller, error) != 0) return -1;
  if (l->file.has_bus) return 0;
  return app_fail(error, APP_BAD_INPUT,
                  "%s: bus: missing key, --can needs it (models/leg_bench.yaml has one)", s->model);
}

/* the interface, and the line that stops it */
static int parse_sources(const struct loop_settings *s, struct source_spec spec[2], struct app_error *error) {
  char text[256];

  if (source_spec_parse(s->can, &spec[0], error) != 0) return -1;
  if (!s->estop) return 0;
  if ((size_t)snprintf(text, sizeof text, "estop:%s", s->estop) >= sizeof text)
    return app_fail(error, APP_BAD_INPUT, "--estop: too long: %.60s", s->estop);
  return source_spec_parse(text, &spec[1], error);
}

static int run(struct loop *l, const struct session_settings *settings, const struct source_spec *spec,
               struct app_error *error) {
  int result = session_open(&l->session, settings, spec, l->settings->estop ? 2 : 1, error);

  if (result == 0) {
    feed_init(&l->feed, &l->file, &l->controller, &l->session.player.points, l->settings->speed_lag_s);
    result = session_run(&l->session, error);
  }
  session_close(&l->session);
  return result;
}

int loop_run(struct loop_settings *settings, struct app_error *error) {
  static struct loop loop;
  static struct source_spec spec[2];
  struct session_settings *session = &settings->session;
  int result;

  loop.settings = settings;
  if (read_model(&loop, error) != 0) return -1;
  loop.hook =
      (struct player_feed){loop.controller.settings.tick_s, LOOP_REST_S, &loop, make_row, report, print};
  session->feed = &loop.hook;
  session->play_on = settings->can;
  session->source.stop = &loop.session.stop_line;
  if (settings->estop) session->stop = settings->can;
  loop.fd = can_socket_open(settings->can, error);
  if (loop.fd < 0) return -1;
  result = can_socket_only(loop.fd, leg_bus_listened, LEG_BUS_LISTENED) == 0
               ? parse_sources(settings, spec, error)
               : app_fail(error, APP_FAILED, "--can: %.40s: %s", settings->can, strerror(errno));
  if (result == 0) result = run(&loop, session, spec, error);
  can_socket_close(loop.fd);
  return result;
}
