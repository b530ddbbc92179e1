/* session.c: threads, their start and their end. */
#define _GNU_SOURCE

#include "session.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "acquire/host/clocks.h"
#include "events_file.h"

enum {
#if defined(__SANITIZE_THREAD__)
  STACK = 4 << 20, /* the sanitizer keeps its own there */
#else
  STACK = 512 << 10,
#endif
  READER_POLL_MS = 20,
  WRITER_CYCLE_NS = 20000000,
  WATCH_POLL_MS = 100,
  GATHER_NS = 1000000,
  MANY = 64,
  PLAY_AFTER_NS = 300000000,
  RECORD_ON_NS = 500000000, /* after the last set-point */
  NS_PER_MS = 1000000,
  NS_PER_S = 1000000000,
  STATS_EVERY = 10 /* seconds */
};

/* what a reader's thread is given */
struct reader {
  struct session *session;
  struct source *source;
};
static struct reader reader[MAX_SOURCES];

static int is_set(const int *flag) {
  return __atomic_load_n(flag, __ATOMIC_ACQUIRE);
}

static void set(int *flag) {
  __atomic_store_n(flag, 1, __ATOMIC_RELEASE);
}

/* ---- threads ------------------------------------------------------------------------ */

/* all threads have run their loop once before anybody counts faults */
static void warm_up_together(struct session *s) {
  pthread_barrier_wait(&s->warm);
}

/* not when more come than any bus can carry: then every moment counts */
static int gathers(const struct source *source) {
  return source_is_can(source) && source->at_once < MANY;
}

/* a failure is kept, and ends the recording */
static void read_source(struct source *source) {
  if (source->ended)
    ring_set_watermark(&source->ring, clock_real_ns());
  else if (source->ops->read(source) < 0)
    __atomic_store_n(&source->failure, errno, __ATOMIC_RELEASE);
}

static void *run_reader(void *argument) {
  const struct reader *r = argument;
  struct source *source = r->source;
  struct session *s = r->session;
  realtime_enter(&s->realtime, REALTIME_READER);
  read_source(source);
  warm_up_together(s);
  while (!is_set(&s->stop_reading)) {
    struct pollfd ready[] = {{.fd = source->ended ? -1 : source->fd, .events = POLLIN},
                             {.fd = source->events, .events = POLLIN}};
    /* the kernel has stamped it: a moment later there are more of them, for one wake-up */
    if (poll(ready, 2, READER_POLL_MS) > 0 && gathers(source)) clock_sleep_until(clock_mono_ns() + GATHER_NS);
    if (!source->failure) read_source(source);
  }
  if (!source->failure) source->ops->finish(source);
  return NULL;
}

static void *run_writer(void *argument) {
  struct session *s = argument;
  int failed = writer_cycle(&s->writer, 0);
  realtime_enter(&s->realtime, REALTIME_WRITER);
  warm_up_together(s);
  for (int64_t next = clock_mono_ns(); !is_set(&s->stop_writing) && !failed;) {
    next += WRITER_CYCLE_NS;
    if (next < clock_mono_ns()) next = clock_mono_ns();
    clock_sleep_until(next);
    failed = writer_cycle(&s->writer, 0);
  }
  if (!failed) failed = writer_cycle(&s->writer, 1);
  for (int i = 0; i < s->sources && failed; i++) set(&s->source[i].writer_dead);
  return NULL;
}

/* begins a little later, so that the record has what was before */
static void *run_player(void *argument) {
  struct session *s = argument;
  realtime_enter(&s->realtime, REALTIME_PLAYER);
  s->player.start_ns = clock_mono_ns() + PLAY_AFTER_NS;
  warm_up_together(s);
  player_run(&s->player);
  return NULL;
}

/* the disk may take its time; nobody waits for this thread while recording. A failure is seen by the writer */
static void *run_sync(void *argument) {
  struct session *s = argument;
  int64_t next = clock_mono_ns();
  warm_up_together(s);
  while (!is_set(&s->stop_writing)) {
    clock_sleep_until(clock_mono_ns() + WATCH_POLL_MS * NS_PER_MS);
    if (clock_mono_ns() < next) continue;
    if (writer_sync(&s->writer) != 0) break;
    next = clock_mono_ns() + NS_PER_S;
  }
  return NULL;
}

static void *run_compressor(void *argument) {
  struct session *s = argument;
  warm_up_together(s);
  compressor_run(&s->compressor);
  return NULL;
}

static int start(pthread_t *thread, void *(*run)(void *), void *argument, struct app_error *error) {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, STACK);
  const int failure = pthread_create(thread, &attributes, run, argument);
  pthread_attr_destroy(&attributes);
  return failure ? app_fail(error, APP_FAILED, "a thread cannot be started: %s", strerror(failure)) : 0;
}

/* A thread that does not start ends the program: those that wait at the barrier die with it. */
static int start_threads(struct session *s, struct app_error *error) {
  const int others = 3 + (s->settings->play != NULL) + (s->settings->compress != 0);
  pthread_barrier_init(&s->warm, NULL, (unsigned)(s->sources + others));
  for (int i = 0; i < s->sources; i++) {
    reader[i] = (struct reader){s, &s->source[i]};
    if (start(&s->reader_thread[i], run_reader, &reader[i], error) != 0) return -1;
  }
  if (start(&s->writer_thread, run_writer, s, error) != 0) return -1;
  if (s->settings->play && start(&s->player_thread, run_player, s, error) != 0) return -1;
  if (s->settings->compress && start(&s->compress_thread, run_compressor, s, error) != 0) return -1;
  return start(&s->sync_thread, run_sync, s, error);
}

/* ---- opening ------------------------------------------------------------------------ */

static int open_signals(struct app_error *error) {
  sigset_t set_of;
  sigemptyset(&set_of);
  sigaddset(&set_of, SIGINT);
  sigaddset(&set_of, SIGTERM);
  sigaddset(&set_of, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &set_of, NULL);
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN); /* a limit on file size is a failed write */
  const int fd = signalfd(-1, &set_of, SFD_CLOEXEC | SFD_NONBLOCK);
  return fd >= 0 ? fd : app_fail(error, APP_FAILED, "no signals: %s", strerror(errno));
}

static int open_sources(struct session *s, const struct source_spec *spec, int sources,
                        struct app_error *error) {
  for (int i = 0; i < sources; i++) {
    for (int j = 0; j < i; j++)
      if (strcmp(spec[i].name, spec[j].name) == 0)
        return app_fail(error, APP_BAD_INPUT, "two sources are called '%s'", spec[i].name);
    s->sources = i + 1;
    if (source_open(&s->source[i], &spec[i], (uint8_t)i, &s->settings->source, error) != 0) return -1;
  }
  return 0;
}

static void say_what_was_refused(const struct session *s) {
  const struct realtime *rt = &s->realtime;
  if (rt->lock_refused) app_note("memory is not locked: %s (docs: privileges)", strerror(rt->lock_refused));
  if (rt->fifo_refused) app_note("no real-time priority: %s (docs: privileges)", strerror(rt->fifo_refused));
  for (int i = 0; i < s->sources; i++) {
    const struct source *source = &s->source[i];
    if (source->spec.kind != SOURCE_CAN) continue;
    if (!source->link.up) app_note("%s is down; it is recorded when it comes up", source->spec.name);
    if (source->receive_buffer < RECEIVE_BYTES)
      app_note("%s: the kernel grants a receive buffer of %d bytes only", source->spec.name,
               source->receive_buffer);
    if (source->link.bus.state == BUS_OFF)
      app_note("%s is bus-off; it is not restarted from here", source->spec.name);
  }
}

/* before anything is sent: a pressed button lets nobody play */
static int check_buttons(const struct session *s, struct app_error *error) {
  for (int i = 0; i < s->sources; i++) {
    const struct source *source = &s->source[i];
    if (source->spec.kind != SOURCE_ESTOP) continue;
    if (source->pressed == 1 && s->settings->play)
      return app_fail(error, APP_FAILED, "%s: the emergency stop is pressed: nothing is played",
                      source->spec.name);
    if (source->pressed == 1) app_note("%s: the emergency stop is pressed", source->spec.name);
    if (source->pressed < 0 && s->settings->play)
      return app_fail(error, APP_FAILED,
                      "%s: whether the emergency stop is pressed cannot be read (with both edges it has no "
                      "pressed level): nothing is played",
                      source->spec.name);
  }
  return 0;
}

static int open_stop_and_player(struct session *s, struct app_error *error) {
  const struct session_settings *settings = s->settings;
  if (settings->stop && stop_line_open(&s->stop_line, settings->stop, error) != 0) return -1;
  if (!settings->play) return 0;
  if (player_open(&s->player, settings->play, settings->limits, settings->play_on, settings->feed, error) !=
      0)
    return -1;
  s->player.latest_ns = llround(settings->play_latest_s * NS_PER_S);
  s->stop_line.playing = &s->player.stop;
  return 0;
}

int session_open(struct session *s, const struct session_settings *settings, const struct source_spec *spec,
                 int sources, struct app_error *error) {
  memset(s, 0, sizeof *s);
  s->settings = settings;
  s->player.port.fd = s->stop_line.port.fd = s->stop_line.told = s->signals = -1;
  s->watch.netlink = s->watch.link_events = s->watch.clock_set = -1;
  s->files.reserve = s->files.full = s->files.folder = s->files.file[0].fd = s->files.file[1].fd = -1;
  s->realtime.latency_fd = -1;
  s->signals = open_signals(error);
  if (s->signals < 0 || open_stop_and_player(s, error) != 0) return -1;
  if (open_sources(s, spec, sources, error) != 0 || check_buttons(s, error) != 0) return -1;
  if (watch_open(&s->watch, s->source, s->sources, settings->stop ? &s->stop_line : NULL, error) != 0)
    return -1;
  if (file_pair_open(&s->files, settings->out, settings->overwrite, error) != 0) return -1;
  if (settings->divide.bytes || settings->divide.ns) file_pair_divide(&s->files, settings->divide);
  if (settings->compress && compressor_open(&s->compressor, &s->files, error) != 0) return -1;
  realtime_prepare(&s->realtime, settings->realtime);
  writer_init(&s->writer, &s->files, s->source, s->sources, &s->watch.events);
  return 0;
}

void session_close(struct session *s) {
  for (int i = 0; i < s->sources; i++) source_close(&s->source[i]);
  stop_line_close(&s->stop_line);
  player_close(&s->player);
  watch_close(&s->watch);
  if (s->signals >= 0) close(s->signals);
  compressor_close(&s->compressor);
  file_pair_close(&s->files);
  realtime_release(&s->realtime);
}

/* ---- running ------------------------------------------------------------------------ */

static const char *reason_text(const struct session *s) {
  switch (s->reason) {
  case REASON_DURATION: return "duration";
  case REASON_SIGNAL: return "signal";
  case REASON_PLAYED: return "trajectory played";
  case REASON_CLOSED: return "sources closed";
  case REASON_SOURCE: return "source failed";
  case REASON_DISK: return file_pair_failure(&s->files) == ENOSPC ? "disk full" : "write failed";
  default: return "none";
  }
}

static int all_ended(const struct session *s) {
  int ended = 0;
  for (int i = 0; i < s->sources; i++) ended += is_set(&s->source[i].ended);
  return ended == s->sources;
}

/* without a duration, the recording ends with what is played */
static int has_played(struct session *s) {
  if (!s->settings->play || s->settings->duration_s > 0.0 || !is_set(&s->player.end)) return 0;
  const int64_t now = clock_mono_ns();
  if (s->played_ns == 0) s->played_ns = now;
  return now - s->played_ns > RECORD_ON_NS;
}

static const struct source *failed_source(const struct session *s) {
  for (int i = 0; i < s->sources; i++)
    if (is_set(&s->source[i].failure)) return &s->source[i];
  return NULL;
}

static enum session_reason reason_to_end(struct session *s) {
  struct signalfd_siginfo what;
  if (is_set(&s->source[0].writer_dead)) return REASON_DISK;
  if (read(s->signals, &what, sizeof what) == (ssize_t)sizeof what) return REASON_SIGNAL;
  if (s->settings->duration_s > 0.0 && clock_mono_ns() >= s->watch.end_ns) return REASON_DURATION;
  if (has_played(s)) return REASON_PLAYED;
  if (failed_source(s)) return REASON_SOURCE;
  return all_ended(s) ? REASON_CLOSED : REASON_NONE;
}

static void each_second(struct session *s) {
  const int live = !s->settings->quiet && isatty(STDERR_FILENO);
  s->second++;
  s->next_second_ns += NS_PER_S;
  watch_clock(&s->watch);
  watch_links(&s->watch, s->second % STATS_EVERY == 0);
  if (live) watch_live_line(&s->watch);
}

/* until the next second or the end, or until a signal, an emergency stop, or the kernel's word about an interface */
static void wait_for_something(struct session *s) {
  struct pollfd what[] = {{.fd = s->signals, .events = POLLIN},
                          {.fd = s->watch.link_events, .events = POLLIN},
                          {.fd = s->stop_line.told, .events = POLLIN},
                          {.fd = s->watch.clock_set, .events = POLLIN}};
  int64_t until = s->next_second_ns;
  if (s->watch.end_ns && s->watch.end_ns < until) until = s->watch.end_ns;
  const int64_t left_ms = (until - clock_mono_ns()) / NS_PER_MS + 1;
  poll(what, sizeof what / sizeof what[0],
       (int)(left_ms < 0               ? 0
             : left_ms < WATCH_POLL_MS ? left_ms
                                       : WATCH_POLL_MS));
  if (what[2].revents & POLLIN) watch_stops(&s->watch);
  if (what[3].revents & POLLIN) watch_clock_set(&s->watch);
  if (what[1].revents & POLLIN) watch_link_events(&s->watch);
}

static void watch_all(struct session *s) {
  while ((s->reason = reason_to_end(s)) == REASON_NONE) {
    wait_for_something(s);
    if (clock_mono_ns() >= s->next_second_ns) each_second(s);
  }
}

static void begin(struct session *s) {
  s->watch.start_ns = clock_mono_ns();
  s->next_second_ns = s->watch.start_ns + NS_PER_S;
  if (s->settings->duration_s > 0.0)
    s->watch.end_ns = s->watch.start_ns + llround(s->settings->duration_s * NS_PER_S);
  watch_clock(&s->watch);
  watch_links(&s->watch, 0);
  if (!s->settings->quiet && isatty(STDERR_FILENO)) watch_live_line(&s->watch);
}

static struct events_end how_it_ended(const struct session *s) {
  return (struct events_end){reason_text(s), &s->writer, &s->loop};
}

static void stop_player(struct session *s) {
  if (!s->settings->play) return;
  set(&s->player.stop);
  pthread_join(s->player_thread, NULL);
  clock_sleep_until(clock_mono_ns() + 2 * GATHER_NS);
}

/* What has been lost on the way to the disk is known before the last line is written, but for that line itself. */
static void finish_files(struct session *s) {
  struct text *json = &s->files.file[FILE_JSON].text;
  if (writer_sync(&s->writer) != 0) s->reason = REASON_DISK;
  if (file_pair_failure(&s->files)) {
    writer_give_up(&s->writer, s->watch.abandoned);
    writer_tell_not_synced(&s->writer);
  }
  if (s->settings->play) player_report(&s->player, json);
  const struct events_end facts = how_it_ended(s);
  events_file_end(json, &facts);
  file_pair_flush(&s->files, FILE_JSON);
  file_pair_sync(&s->files, FILE_JSON);
}

/* the player first: its last word is still recorded; then readers, so that the writer's last cycle has everything */
static void end(struct session *s) {
  if (s->reason == REASON_DISK) file_pair_release(&s->files);
  stop_player(s);
  set(&s->stop_reading);
  for (int i = 0; i < s->sources; i++) pthread_join(s->reader_thread[i], NULL);
  watch_link_events(&s->watch);
  watch_links(&s->watch, 1);
  watch_clock(&s->watch);
  set(&s->stop_writing);
  pthread_join(s->writer_thread, NULL);
  pthread_join(s->sync_thread, NULL);
  watch_stops(&s->watch);
  finish_files(s);
}

/* The recording has ended; files that are full are still compressed, until somebody is impatient. */
static void finish_compressing(struct session *s) {
  struct compressor *c = &s->compressor;
  struct signalfd_siginfo what;
  if (!s->settings->compress) return;
  set(&c->last);
  while (!is_set(&c->ended)) {
    struct pollfd impatient = {.fd = s->signals, .events = POLLIN};
    if (poll(&impatient, 1, WATCH_POLL_MS) > 0 && read(s->signals, &what, sizeof what) > 0) set(&c->give_up);
  }
  pthread_join(s->compress_thread, NULL);
  if (c->refused)
    app_note("%d of %d full files are not compressed: %s", s->files.settled - c->done, s->files.settled,
             strerror(c->failure));
  else if (c->done < s->files.settled)
    app_note("%d of %d full files are not compressed", s->files.settled - c->done, s->files.settled);
}

struct session_result session_result(const struct session *s) {
  return (struct session_result){s->sources, writer_lost(&s->writer), writer_knows(&s->writer), s->loop};
}

static void print_summary(const struct session *s) {
  const struct events_end facts = how_it_ended(s);
  const double seconds = 1e-9 * (double)(clock_mono_ns() - s->watch.start_ns);
  events_file_summary(&facts, s->files.file[FILE_LOG].path, seconds);
  if (s->settings->play) player_print(&s->player);
}

/* what makes the exit status 1, the gravest first */
static int judge(const struct session *s, struct app_error *error) {
  const struct source *failed = failed_source(s);
  const int disk = file_pair_failure(&s->files);
  const struct writer_stops stops = writer_stops(&s->writer);
  if (disk)
    return app_fail(error, APP_FAILED, "%s: %s; the recording ends here, what was written before can be read",
                    s->files.file[s->files.failed_in].path, strerror(disk));
  if (failed)
    return app_fail(error, APP_FAILED, "%s: cannot be read any longer: %s", failed->spec.name,
                    strerror(failed->failure));
  if (stops.failed || stops.partial)
    return app_fail(error, APP_FAILED,
                    "of %llu emergency stops %llu not sent, %llu sent only in part; %s says which",
                    (unsigned long long)stops.all, (unsigned long long)stops.failed,
                    (unsigned long long)stops.partial, s->files.file[FILE_JSON].path);
  if (s->player.end >= PLAYER_TOO_LATE)
    return app_fail(error, APP_FAILED, "%s: playing ended at set-point %zu: %s", s->settings->play,
                    s->player.rows_sent, player_end_text(&s->player));
  if (s->settings->play && s->player.hold_failure)
    return app_fail(error, APP_FAILED, "%s: the drives were not told to hold: %s", s->settings->play_on,
                    strerror(s->player.hold_failure));
  if (writer_lost(&s->writer))
    return app_fail(error, APP_FAILED, "%llu lost; %s says where",
                    (unsigned long long)writer_lost(&s->writer), s->files.file[FILE_JSON].path);
  if (!writer_knows(&s->writer))
    return app_fail(error, APP_FAILED,
                    "an interface vanished, and whether frames were lost then cannot be told; %s says when",
                    s->files.file[FILE_JSON].path);
  return 0;
}

int session_run(struct session *s, struct app_error *error) {
  const int live = !s->settings->quiet && isatty(STDERR_FILENO);
  const struct events_begin facts = {s->files.file[FILE_LOG].path, s->source, s->sources,
                                     s->settings->source.gpio->name, &s->realtime};
  if (!s->settings->quiet) say_what_was_refused(s);
  events_file_begin(&s->files.file[FILE_JSON].text, &facts);
  if (start_threads(s, error) != 0) return -1;
  begin(s);
  warm_up_together(s);
  s->loop = loop_count_now();
  watch_all(s);
  s->loop = loop_count_since(&s->loop);
  end(s);
  if (live) watch_live_end();
  if (!s->settings->quiet) print_summary(s);
  finish_compressing(s);
  return judge(s, error);
}
