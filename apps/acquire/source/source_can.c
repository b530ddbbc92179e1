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

static void ask_hardware_stamps(struct source *s) {
  if (s->hardware_stamps) link_ask_hardware_stamps(s->spec.name, &s->stamps_before);
}

/* Another interface has the name now. The one before has gone, and what it left in the queue is ours; or it has another name,
 * and is no longer what is recorded. */
static void adopt(struct source *s, int index) {
  const int before = s->port.index;
  if (s->gone) {
    memmove(s->former + 1, s->former, (FORMER - 1) * sizeof s->former[0]);
    s->former[0] = before;
  }
  s->port.index = index;
  include(s, index);
  if (!s->gone) exclude(s, before);
  s->gone = 0;
  ask_hardware_stamps(s);
}

/* after lost events: what is so now */
static void look_again(struct source *s) {
  const int before = s->port.index;
  const int now = can_port_look(&s->port);
  s->port.index = before;
  if (now && now != before) adopt(s, now);
}

static void follow_events(struct source *s) {
  struct link_event event;
  for (int n; s->events >= 0 && (n = link_next_event(s->events, &event)) != 0;) {
    if (n < 0) look_again(s);
    if (n < 0 || !event.is_can) continue;
    if (event.gone) {
      s->gone |= event.index == s->port.index;
      include(s, event.index);
    } else if (event.index != s->port.index && strcmp(event.name, s->spec.name) == 0) {
      adopt(s, event.index);
    }
  }
}

/* An interface that is not known has an event in the queue that tells its name. */
static int is_ours(struct source *s, int index) {
  if (index == s->port.index || index == 0) return 1;
  follow_events(s);
  if (index == s->port.index || find(s->former, FORMER, index) >= 0) return 1;
  exclude(s, index);
  return 0;
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
  ask_hardware_stamps(s);
  int reason = can_port_open(&s->port, s->spec.name);
  s->fd = s->port.fd;
  if (reason) return refuse_kernel(s, reason, error);
  s->port.index = s->link.index;
  include(s, s->link.index);
  update_filter(s);
  reason = begin_to_receive(s);
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
  if (!is_ours(s, can_batch_interface(s->batch, i))) {
    source_add(&s->count.foreign, 1);
    return;
  }
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

/* what is queued first, then what has become of the interface */
static int read_can(struct source *s) {
  const int result = drain(s);
  follow_events(s);
  return result;
}

static int read_inherited(struct source *s) {
  return drain(s);
}

/* Frames that come from now on are not ours: what has come until now can then be read to its end. */
static void finish_can(struct source *s) {
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
  link_restore_stamps(s->spec.name, &s->stamps_before);
  if (s->events >= 0) close(s->events);
  close_inherited(s);
}

const struct source_ops source_can = {open_can, read_can, finish_can, close_can};
const struct source_ops source_fd = {open_inherited, read_inherited, finish_inherited, close_inherited};
