/* source_can.c: a CAN interface, or a datagram socket that brings the same frames. */
#define _GNU_SOURCE

#include <errno.h>
#include <linux/can/raw.h>
#include <linux/net_tstamp.h>
#include <linux/sock_diag.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "acquire/host/clocks.h"
#include "can_batch.h"
#include "source.h"

#ifndef SO_MEMINFO
#define SO_MEMINFO 55
#endif

enum { SETTLE_NS = 2000000, WATERMARK_GUARD_NS = 2000000 };

static int set_int(int fd, int level, int option, int value) {
  return setsockopt(fd, level, option, &value, sizeof value);
}

/* ---- opening ------------------------------------------------------------------ */

/* the kernel doubles what it is given; beyond net.core.rmem_max only with CAP_NET_ADMIN */
static int enlarge(int fd, uint64_t bytes) {
  int granted = 0;
  socklen_t size = sizeof granted;
  if (set_int(fd, SOL_SOCKET, SO_RCVBUFFORCE, (int)bytes) != 0)
    set_int(fd, SOL_SOCKET, SO_RCVBUF, (int)bytes);
  getsockopt(fd, SOL_SOCKET, SO_RCVBUF, &granted, &size);
  return granted;
}

static void ask_stamps(int fd, int hardware) {
  int flags = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE;
  if (hardware) flags |= SOF_TIMESTAMPING_RX_HARDWARE | SOF_TIMESTAMPING_RAW_HARDWARE;
  if (set_int(fd, SOL_SOCKET, SO_TIMESTAMPING, flags) != 0) set_int(fd, SOL_SOCKET, SO_TIMESTAMPNS, 1);
}

/* Everything is set before the first frame can come. */
static int begin_to_receive(struct source *s) {
  s->receive_buffer = enlarge(s->fd, s->settings->receive_bytes);
  ask_stamps(s->fd, s->hardware_stamps);
  set_int(s->fd, SOL_SOCKET, SO_RXQ_OVFL, 1);
  s->takes_fd_frames = set_int(s->fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, 1) == 0;
  return can_port_receive_all(&s->port);
}

/* ---- which interface it is ----------------------------------------------------------- */

static int find(const int *index, int n, int wanted) {
  for (int i = 0; i < n; i++)
    if (index[i] == wanted) return i;
  return -1;
}

static void update_filter(struct source *s) {
  can_port_exclude(&s->port, s->excluded, s->excluded_count);
}

/* its frames are not ours, and need not be read again; where there is no room, they are read and left out */
static void exclude(struct source *s, int index) {
  if (s->excluded_count == CAN_PORT_EXCLUDED || find(s->excluded, s->excluded_count, index) >= 0) return;
  s->excluded[s->excluded_count++] = index;
  update_filter(s);
}

static void include(struct source *s, int index) {
  const int i = find(s->excluded, s->excluded_count, index);
  if (i < 0) return;
  s->excluded[i] = s->excluded[--s->excluded_count];
  update_filter(s);
}

/* of this interface; the one before gets back what it had */
static void ask_hardware_stamps(struct source *s, int index) {
  link_restore_stamps(&s->stamps_before);
  if (s->hardware_stamps) link_ask_hardware_stamps(index, &s->stamps_before);
}

/* The interface of the name is another one now. The one before has gone, and what it left in the queue is ours; or it has
 * another name, and is no longer what is recorded. */
static void adopt(struct source *s, const struct link_state *now) {
  const int before = s->port.index;
  s->port.index = now->index;
  include(s, now->index);
  if (!s->gone) exclude(s, before);
  s->gone = 0;
  tally_begin(&s->tally, now->index, now->driver, now->counter);
  s->tally.begin_unknown = now->up && now->counter[LINK_RX_PACKETS] != 0;
  s->tally.lost_before = s->count.lost;
  ask_hardware_stamps(s, now->index);
}

static void settle(struct source *s, struct vanished *v) {
  struct item item = {.kind = ITEM_VANISHED, .source = s->index, .real_ns = clock_real_ns()};
  const struct tally_missing missing = tally_missing(&v->tally, v->counter, s->count.lost);
  item.is.vanished.index = v->tally.index;
  item.is.vanished.read = v->tally.read;
  item.is.vanished.received = missing.received;
  item.is.vanished.lost = missing.lost;
  item.is.vanished.more = missing.more;
  item.is.vanished.unknown = missing.unknown;
  v->state = SETTLED;
  source_push(s, &item);
}

/* Its account waits until what it left in the queue has been read. */
static void take_leave(struct source *s, const uint64_t counter[LINK_COUNTERS]) {
  struct vanished *v = s->vanished, *last = v + FORMER - 1;
  if (last->state != SETTLED) { /* so many within one look: what it left is not waited for */
    last->tally.begin_unknown = 1;
    settle(s, last);
  }
  memmove(v + 1, v, (FORMER - 1) * sizeof *v);
  v->tally = s->tally;
  memcpy(v->counter, counter, sizeof v->counter);
  v->state = s->finishing ? SETTLED : JUST_GONE;
  s->tally.index = 0;
  s->gone = 1;
}

/* Events were lost: what is so now. Of an interface that came or went meanwhile the counters are not known. */
static void look_again(struct source *s) {
  const int before = s->port.index;
  struct link_state now = {.index = can_port_look(&s->port), .up = 1, .counter = {[LINK_RX_PACKETS] = 1}};
  const uint64_t none[LINK_COUNTERS] = {0};
  s->port.index = before;
  if (!s->gone && !can_port_exists(&s->port)) {
    s->tally.begin_unknown = 1;
    take_leave(s, none);
  }
  if (now.index && now.index != before) adopt(s, &now);
}

static void follow_events(struct source *s) {
  struct link_event event;
  for (int n; s->events >= 0 && (n = link_next_event(s->events, &event)) != 0;) {
    const struct link_state *now = &event.now;
    if (n < 0) look_again(s);
    if (n < 0 || !now->is_can) continue;
    if (event.gone) {
      if (now->index == s->port.index && !s->gone) take_leave(s, now->counter);
      include(s, now->index);
    } else if (now->index != s->port.index && strcmp(now->name, s->spec.name) == 0) {
      adopt(s, now);
    }
  }
}

/* The tally of an interface that is ours, or was; NULL of another. */
static struct tally *tally_of(struct source *s, int index) {
  if (index == s->tally.index) return &s->tally;
  for (int i = 0; i < FORMER; i++)
    if (index == s->vanished[i].tally.index) return &s->vanished[i].tally;
  return NULL;
}

/* An interface that is not known has an event in the queue that tells its name. */
static struct tally *whose(struct source *s, int index) {
  struct tally *tally = tally_of(s, index);
  if (tally) return tally;
  follow_events(s);
  tally = tally_of(s, index);
  if (!tally) exclude(s, index);
  return tally;
}

/* ---- opening the one and the other -------------------------------------------------------- */

static int query(struct source *s) {
  const int netlink = link_open(0);
  if (netlink < 0) return -1;
  const int result = link_query(netlink, s->spec.name, &s->link);
  s->excluded_count = link_all_can(netlink, s->excluded, CAN_PORT_EXCLUDED);
  close(netlink);
  return result;
}

/* Its counters are read on either side of the beginning: what comes between may have been before it. */
static int begin_to_count(struct source *s) {
  struct link_state before = {.index = 0}, after = before;
  const int netlink = link_open(0);
  if (netlink >= 0) link_query_index(netlink, s->link.index, &before);
  const int reason = begin_to_receive(s);
  if (netlink >= 0) link_query_index(netlink, s->link.index, &after);
  if (netlink >= 0) close(netlink);
  tally_begin(&s->tally, s->link.index, before.driver, before.counter);
  s->tally.begin_unknown = before.index != after.index || !before.index;
  s->tally.spread = after.counter[LINK_RX_PACKETS] - before.counter[LINK_RX_PACKETS];
  return reason;
}

static int no_such_interface(const struct source *s, struct app_error *error) {
  char names[256];
  if (s->link.index)
    return app_fail(error, APP_BAD_INPUT, "%s: no CAN interface, but one of another kind", s->spec.name);
  link_list(names, sizeof names);
  return app_fail(error, APP_BAD_INPUT, "%s: no such interface (CAN interfaces here: %s)", s->spec.name,
                  names);
}

static int refuse_kernel(const struct source *s, int reason, struct app_error *error) {
  if (reason == EAFNOSUPPORT || reason == EPROTONOSUPPORT)
    return app_fail(error, APP_FAILED, "%s: this kernel has no SocketCAN (modules can and can-raw)",
                    s->spec.name);
  return app_fail(error, APP_FAILED, "%s: cannot be opened: %s", s->spec.name, strerror(reason));
}

static int open_can(struct source *s, struct app_error *error) {
  s->events = link_open(1); /* first: no change after the query is missed */
  if (s->events < 0 || query(s) != 0)
    return app_fail(error, APP_FAILED, "%s: the kernel does not answer: %s", s->spec.name, strerror(errno));
  if (!s->link.index || !s->link.is_can) return no_such_interface(s, error);
  s->batch = can_batch_new();
  if (!s->batch) return app_fail(error, APP_FAILED, "out of memory");
  s->hardware_stamps = !s->settings->software_stamps && link_has_hardware_stamps(s->spec.name);
  ask_hardware_stamps(s, s->link.index);
  int reason = can_port_open(&s->port, s->spec.name);
  s->fd = s->port.fd;
  if (reason) return refuse_kernel(s, reason, error);
  s->port.index = s->link.index;
  include(s, s->link.index);
  update_filter(s);
  reason = begin_to_count(s);
  return reason ? refuse_kernel(s, reason, error) : 0;
}

static int open_inherited(struct source *s, struct app_error *error) {
  int type = 0;
  socklen_t size = sizeof type;
  s->fd = -1;
  if (getsockopt(s->spec.fd, SOL_SOCKET, SO_TYPE, &type, &size) != 0 ||
      (type != SOCK_DGRAM && type != SOCK_SEQPACKET))
    return app_fail(error, APP_BAD_INPUT, "fd:%s=%d: expected an open datagram socket", s->spec.name,
                    s->spec.fd);
  s->batch = can_batch_new();
  if (!s->batch) return app_fail(error, APP_FAILED, "out of memory");
  s->fd = s->spec.fd;
  s->takes_fd_frames = 1;
  s->link = (struct link_state){.is_can = 1, .up = 1, .bus = {BUS_UNKNOWN, -1, -1}};
  s->receive_buffer = enlarge(s->fd, s->settings->receive_bytes);
  set_int(s->fd, SOL_SOCKET, SO_TIMESTAMPNS, 1);
  return 0;
}

/* ---- reading ------------------------------------------------------------------ */

static void report_drops(struct source *s, uint32_t drops, int64_t real_ns) {
  const uint32_t more = drops - s->drops_seen;
  if (more == 0) return;
  struct item item = {.kind = ITEM_DROP, .source = s->index, .real_ns = real_ns};
  item.is.drop.lost = more;
  item.is.drop.where = ITEM_IN_SOCKET;
  s->drops_seen = drops;
  source_add(&s->count.lost, more);
  source_push(s, &item);
}

static void take(struct source *s, int i) {
  struct item item;
  uint32_t drops = s->drops_seen;
  memset(&item, 0, sizeof item);
  item.source = s->index;
  source_add(&s->count.read, can_batch_size(s->batch, i) != 0);
  if (can_batch_item(s->batch, i, &item, &drops) != 0) {
    source_add(&s->count.malformed, can_batch_size(s->batch, i) != 0);
    return;
  }
  if (item.real_ns == 0) item.real_ns = clock_real_ns();
  report_drops(s, drops, item.real_ns);
  struct tally *tally = whose(s, can_batch_interface(s->batch, i));
  if (!tally) {
    source_add(&s->count.foreign, 1);
    return;
  }
  tally->own += (uint64_t)can_batch_is_own(s->batch, i);
  tally->read += (uint64_t)(tally->counts_own || !can_batch_is_own(s->batch, i));
  if (item.hardware_ns) stamp_pair_publish(&s->pair, item.hardware_ns, item.real_ns);
  source_add(item.kind == ITEM_FRAME ? &s->count.frames : &s->count.errors, 1);
  s->last_ns = item.real_ns;
  source_push(s, &item);
}

static int writer_is_dead(const struct source *s) {
  return __atomic_load_n(&s->writer_dead, __ATOMIC_ACQUIRE);
}

/* What comes from now on is stamped later than what was there: before the question when that emptied the queue, else the
 * last frame's stamp. */
static void mark(struct source *s, int n, int64_t asked_ns) {
  const int64_t until = n < CAN_BATCH || s->last_ns > asked_ns ? asked_ns : s->last_ns;
  ring_set_watermark(&s->ring, (until < 0 ? 0 : until) - WATERMARK_GUARD_NS);
}

/* everything that is there; the batch is asked for only when the ring has room for it */
static int drain(struct source *s) {
  s->at_once = 0;
  for (;;) {
    while (ring_room(&s->ring) < 2 * CAN_BATCH && !writer_is_dead(s))
      clock_sleep_until(clock_mono_ns() + SETTLE_NS / 4);
    const int64_t asked_ns = clock_real_ns();
    const int n = can_batch_receive(s->batch, s->fd);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno != EAGAIN && errno != EWOULDBLOCK) return -1;
    for (int i = 0; i < n; i++) take(s, i);
    mark(s, n, asked_ns);
    if (n <= 0) return 0;
    s->at_once += (uint32_t)n;
    if (can_batch_size(s->batch, n - 1) == 0) {
      __atomic_store_n(&s->ended, 1, __ATOMIC_RELEASE);
      return 0;
    }
  }
}

/* the counter shows with a later frame only, so it is asked for as well */
static void read_drop_counter(struct source *s) {
  uint32_t memory[SK_MEMINFO_VARS] = {0};
  socklen_t size = sizeof memory;
  if (getsockopt(s->fd, SOL_SOCKET, SO_MEMINFO, memory, &size) == 0 &&
      size > SK_MEMINFO_DROPS * sizeof memory[0])
    report_drops(s, memory[SK_MEMINFO_DROPS], clock_real_ns());
}

static int change_all(struct source *s, int from, int to) {
  int changed = 0;
  for (int i = 0; i < FORMER; i++) {
    if (s->vanished[i].state != from) continue;
    s->vanished[i].state = to;
    changed++;
  }
  return changed;
}

/* What they left is in the queue by now, and so it has been read when that was empty once. */
static int settle_those_that_are_gone(struct source *s) {
  if (!change_all(s, JUST_GONE, BEING_READ)) return 0;
  if (drain(s) != 0) return -1;
  read_drop_counter(s);
  for (int i = FORMER - 1; i >= 0; i--)
    if (s->vanished[i].state == BEING_READ) settle(s, &s->vanished[i]);
  return 0;
}

/* what is queued first, then what has become of the interface */
static int read_can(struct source *s) {
  const int result = drain(s);
  follow_events(s);
  return result != 0 ? result : settle_those_that_are_gone(s);
}

static int read_inherited(struct source *s) {
  return drain(s);
}

/* Frames that come from now on are not ours: what has come until now can then be read to its end. */
static void finish_can(struct source *s) {
  read_can(s);
  s->finishing = 1;
  setsockopt(s->fd, SOL_CAN_RAW, CAN_RAW_FILTER, NULL, 0);
  set_int(s->fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, 0);
  clock_sleep_until(clock_mono_ns() + SETTLE_NS);
  read_can(s);
  read_drop_counter(s);
}

static void finish_inherited(struct source *s) {
  drain(s);
}

static void close_inherited(struct source *s) {
  if (s->fd >= 0) close(s->fd);
  s->fd = -1;
  can_batch_free(s->batch);
  s->batch = NULL;
}

static void close_can(struct source *s) {
  link_restore_stamps(&s->stamps_before);
  if (s->events >= 0) close(s->events);
  close_inherited(s);
}

const struct source_ops source_can = {open_can, read_can, finish_can, close_can};
const struct source_ops source_fd = {open_inherited, read_inherited, finish_inherited, close_inherited};
