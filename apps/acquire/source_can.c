/* source_can.c: a CAN interface, or a datagram socket that brings the same frames. */
#define _GNU_SOURCE

#include <errno.h>
#include <fcntl.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/net_tstamp.h>
#include <linux/sock_diag.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "can_batch.h"
#include "clocks.h"
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

/* a raw socket on the interface; everything is set before it is bound, so that nothing slips by */
static int open_socket(struct source *s) {
  const int fd = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
  if (fd < 0) return -1;
  s->receive_buffer = enlarge(fd, s->settings->receive_bytes);
  ask_stamps(fd, s->hardware_stamps);
  set_int(fd, SOL_SOCKET, SO_RXQ_OVFL, 1);
  set_int(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, CAN_ERR_MASK);
  s->takes_fd_frames = set_int(fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, 1) == 0;
  const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = s->link.index};
  if (bind(fd, (const struct sockaddr *)&address, sizeof address) == 0) {
    s->drops_seen = 0;
    return fd;
  }
  const int reason = errno;
  close(fd);
  errno = reason;
  return -1;
}

static int query(struct source *s) {
  const int netlink = link_open(0);
  if (netlink < 0) return -1;
  const int result = link_query(netlink, s->spec.name, &s->link);
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

static int open_can(struct source *s, struct app_error *error) {
  if (query(s) != 0)
    return app_fail(error, APP_FAILED, "%s: the kernel does not answer: %s", s->spec.name, strerror(errno));
  if (!s->link.index || !s->link.is_can) return no_such_interface(s, error);
  s->hardware_stamps = !s->settings->software_stamps && link_has_hardware_stamps(s->spec.name);
  if (s->hardware_stamps) link_ask_hardware_stamps(s->spec.name);
  s->batch = can_batch_new();
  if (!s->batch) return app_fail(error, APP_FAILED, "out of memory");
  s->fd = open_socket(s);
  if (s->fd >= 0) return 0;
  if (errno == EAFNOSUPPORT || errno == EPROTONOSUPPORT)
    return app_fail(error, APP_FAILED, "%s: this kernel has no SocketCAN (modules can and can-raw)",
                    s->spec.name);
  return app_fail(error, APP_FAILED, "%s: cannot be opened: %s", s->spec.name, strerror(errno));
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
  struct item item = {.kind = ITEM_DROP, .source = s->index, .flags = ITEM_IN_SOCKET, .real_ns = real_ns};
  item.is.number[0] = more;
  s->drops_seen = drops;
  s->lost += more;
  source_push(s, &item);
}

static void take(struct source *s, int i) {
  struct item item;
  uint32_t drops = s->drops_seen;
  memset(&item, 0, sizeof item);
  item.source = s->index;
  if (can_batch_item(s->batch, i, &item, &drops) != 0) {
    s->malformed += can_batch_size(s->batch, i) != 0;
    return;
  }
  if (item.real_ns == 0) item.real_ns = clock_real_ns();
  report_drops(s, drops, item.real_ns);
  if (item.hardware_ns) {
    s->pair_hardware_ns = item.hardware_ns;
    __atomic_store_n(&s->pair_real_ns, item.real_ns, __ATOMIC_RELEASE);
  }
  __atomic_store_n(&s->seen, s->seen + (item.kind == ITEM_FRAME), __ATOMIC_RELAXED);
  source_push(s, &item);
}

/* everything that is there; the batch is asked for only when the ring has room for it */
static int drain(struct source *s) {
  s->at_once = 0;
  for (;;) {
    const int64_t before = clock_real_ns();
    while (ring_room(&s->ring) < 2 * CAN_BATCH && !__atomic_load_n(&s->writer_dead, __ATOMIC_RELAXED))
      clock_sleep_until(clock_mono_ns() + SETTLE_NS / 4);
    const int n = can_batch_receive(s->batch, s->fd);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const int failed = n < 0 && errno != EAGAIN && errno != EWOULDBLOCK;
      if (!failed) ring_set_watermark(&s->ring, before - WATERMARK_GUARD_NS);
      return failed ? -1 : 0;
    }
    s->at_once += (uint32_t)n;
    for (int i = 0; i < n; i++) take(s, i);
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

/* The interface has gone (an adapter was pulled out): a socket on the new one when it is back. */
static int reopen(struct source *s) {
  if (s->fd >= 0) {
    read_drop_counter(s);
    close(s->fd);
    s->fd = -1;
  }
  struct link_state now;
  const int netlink = link_open(0);
  if (netlink < 0) return 0;
  const int found = link_query(netlink, s->spec.name, &now) == 0 && now.index && now.is_can;
  close(netlink);
  if (!found) return 0;
  s->link.index = now.index;
  s->fd = open_socket(s);
  return 0;
}

static int read_can(struct source *s) {
  if (s->fd < 0) return reopen(s);
  while (drain(s) != 0) {
    if (errno == ENODEV || errno == ENXIO) return reopen(s);
    if (errno != ENETDOWN) return -1; /* down: the socket stays bound and goes on when it is up again */
  }
  return 0;
}

static int read_inherited(struct source *s) {
  return drain(s);
}

/* Frames that come from now on are not ours: what has come until now can then be read to its end. */
static void finish_can(struct source *s) {
  if (s->fd < 0) return;
  setsockopt(s->fd, SOL_CAN_RAW, CAN_RAW_FILTER, NULL, 0);
  set_int(s->fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, 0);
  clock_sleep_until(clock_mono_ns() + SETTLE_NS);
  read_can(s);
  if (s->fd >= 0) read_drop_counter(s);
}

static void finish_inherited(struct source *s) {
  drain(s);
}

static void close_can(struct source *s) {
  if (s->fd >= 0) close(s->fd);
  s->fd = -1;
  can_batch_free(s->batch);
  s->batch = NULL;
}

const struct source_face source_can = {open_can, read_can, finish_can, close_can};
const struct source_face source_fd = {open_inherited, read_inherited, finish_inherited, close_can};
