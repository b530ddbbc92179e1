/* link.c: RTM_GETLINK, its attributes, and the driver's stamps. */
#define _GNU_SOURCE

#include "link.h"

#include <errno.h>
#include <linux/can/netlink.h>
#include <linux/ethtool.h>
#include <linux/if_link.h>
#include <linux/net_tstamp.h>
#include <linux/rtnetlink.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

enum { ANSWER = 16384, EVENTS_ROOM = 1 << 20 };

const char *link_counter_name(enum link_counter counter) {
  static const char *const name[] = {"rx_packets",     "rx_errors",        "rx_dropped", "rx_over_errors",
                                     "rx_fifo_errors", "rx_missed_errors", "tx_packets", "tx_dropped"};
  return name[counter];
}

const char *link_change_name(enum link_change change) {
  static const char *const name[] = {"down", "up", "gone", "back", "renamed", "replaced"};
  return name[change];
}

int link_counter_is_loss(enum link_counter counter) {
  return counter == LINK_RX_DROPPED || counter == LINK_RX_OVER || counter == LINK_RX_FIFO ||
         counter == LINK_RX_MISSED;
}

int link_open(int events) {
  const int room = EVENTS_ROOM;
  struct sockaddr_nl address = {.nl_family = AF_NETLINK, .nl_groups = events ? RTMGRP_LINK : 0};
  const int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | (events ? SOCK_NONBLOCK : 0), NETLINK_ROUTE);
  if (fd < 0) return -1;
  if (events && setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room) != 0)
    setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
  if (bind(fd, (struct sockaddr *)&address, sizeof address) == 0) return fd;
  close(fd);
  return -1;
}

/* ---- attributes ------------------------------------------------------------------ */

static const void *payload(const struct rtattr *a) {
  return (const char *)a + RTA_LENGTH(0);
}

static size_t payload_size(const struct rtattr *a) {
  return a->rta_len - RTA_LENGTH(0);
}

/* copies what is there, and at most what fits */
static void take(void *to, size_t size, const struct rtattr *a) {
  const size_t there = payload_size(a);
  memcpy(to, payload(a), there < size ? there : size);
}

static uint32_t take_u32(const struct rtattr *a) {
  uint32_t x = 0;
  take(&x, sizeof x, a);
  return x;
}

/* calls `each` for every attribute between here and here + size */
static void walk(const void *here, size_t size, void (*each)(struct link_state *, const struct rtattr *),
                 struct link_state *state) {
  const char *at = here;
  while (size >= sizeof(struct rtattr)) {
    struct rtattr a;
    memcpy(&a, at, sizeof a);
    if (a.rta_len < sizeof a || a.rta_len > size) return;
    each(state, (const struct rtattr *)(const void *)at);
    const size_t step = RTA_ALIGN(a.rta_len);
    if (step >= size) return;
    at += step;
    size -= step;
  }
}

static void take_controller(struct link_state *s, const struct rtattr *a) {
  struct can_bittiming timing = {0};
  struct can_berr_counter errors = {0};
  switch (a->rta_type) {
  case IFLA_CAN_BITTIMING:
  case IFLA_CAN_DATA_BITTIMING:
    take(&timing, sizeof timing, a);
    *(a->rta_type == IFLA_CAN_BITTIMING ? &s->bitrate : &s->data_bitrate) = timing.bitrate;
    break;
  case IFLA_CAN_STATE: {
    const uint32_t state = take_u32(a);
    s->bus.state = state <= CAN_STATE_STOPPED ? (enum bus_state)state : BUS_UNKNOWN;
    break;
  }
  case IFLA_CAN_RESTART_MS: s->restart_ms = take_u32(a); break;
  case IFLA_CAN_BERR_COUNTER:
    take(&errors, sizeof errors, a);
    s->bus.tx_errors = errors.txerr;
    s->bus.rx_errors = errors.rxerr;
    break;
  default: break;
  }
}

static void take_kind(struct link_state *s, const struct rtattr *a) {
  if (a->rta_type == IFLA_INFO_KIND) {
    take(s->driver, sizeof s->driver - 1, a);
  } else if (a->rta_type == IFLA_INFO_DATA && strcmp(s->driver, "can") == 0) {
    walk(payload(a), payload_size(a), take_controller, s);
  }
}

static void take_attribute(struct link_state *s, const struct rtattr *a) {
  struct rtnl_link_stats64 stats = {0};
  switch (a->rta_type) {
  case IFLA_IFNAME: take(s->name, sizeof s->name - 1, a); break;
  case IFLA_MTU: s->mtu = (int)take_u32(a); break;
  case IFLA_LINKINFO: walk(payload(a), payload_size(a), take_kind, s); break;
  case IFLA_STATS64:
    take(&stats, sizeof stats, a);
    s->counter[LINK_RX_PACKETS] = stats.rx_packets;
    s->counter[LINK_RX_ERRORS] = stats.rx_errors;
    s->counter[LINK_RX_DROPPED] = stats.rx_dropped;
    s->counter[LINK_RX_OVER] = stats.rx_over_errors;
    s->counter[LINK_RX_FIFO] = stats.rx_fifo_errors;
    s->counter[LINK_RX_MISSED] = stats.rx_missed_errors;
    s->counter[LINK_TX_PACKETS] = stats.tx_packets;
    s->counter[LINK_TX_DROPPED] = stats.tx_dropped;
    break;
  default: break;
  }
}

/* ---- the question ------------------------------------------------------------------ */

/* by index, or by name where that is 0 */
static int ask(int netlink, int index, const char *name) {
  struct {
    struct nlmsghdr head;
    struct ifinfomsg info;
    struct rtattr attribute;
    char name[LINK_NAME];
  } question;
  memset(&question, 0, sizeof question);
  question.head.nlmsg_len = index ? NLMSG_LENGTH(sizeof question.info) : sizeof question;
  question.head.nlmsg_type = RTM_GETLINK;
  question.head.nlmsg_flags = NLM_F_REQUEST;
  question.info.ifi_index = index;
  question.attribute.rta_type = IFLA_IFNAME;
  question.attribute.rta_len = (unsigned short)RTA_LENGTH(sizeof question.name);
  if (name) memcpy(question.name, name, strnlen(name, sizeof question.name - 1));
  return send(netlink, &question, question.head.nlmsg_len, 0) < 0 ? -1 : 0;
}

/* one message about an interface; 0, or -1 when it is none */
static int take_message(const char *message, size_t n, struct nlmsghdr *head, struct link_state *state) {
  struct ifinfomsg info;
  const size_t skip = NLMSG_HDRLEN + NLMSG_ALIGN(sizeof info);
  if (n < sizeof *head) return -1;
  memcpy(head, message, sizeof *head);
  if ((head->nlmsg_type != RTM_NEWLINK && head->nlmsg_type != RTM_DELLINK) || head->nlmsg_len > n ||
      head->nlmsg_len < skip)
    return -1;
  memcpy(&info, message + NLMSG_HDRLEN, sizeof info);
  state->index = info.ifi_index;
  state->is_can = info.ifi_type == ARPHRD_CAN;
  state->up = (info.ifi_flags & IFF_UP) != 0;
  walk(message + skip, head->nlmsg_len - skip, take_attribute, state);
  return 0;
}

static int query(int netlink, int index, const char *name, struct link_state *state) {
  char answer[ANSWER];
  struct nlmsghdr head;
  memset(state, 0, sizeof *state);
  state->bus = (struct bus){BUS_UNKNOWN, -1, -1};
  if (ask(netlink, index, name) != 0) return -1;
  const ssize_t n = recv(netlink, answer, sizeof answer, 0);
  if (n < (ssize_t)sizeof head) return -1;
  take_message(answer, (size_t)n, &head, state); /* else it is an error: there is none */
  return 0;
}

int link_query(int netlink, const char *name, struct link_state *state) {
  return query(netlink, 0, name, state);
}

int link_query_index(int netlink, int index, struct link_state *state) {
  return query(netlink, index, NULL, state);
}

/* the kernel sends each event as a message of its own */
int link_next_event(int netlink, struct link_event *event) {
  char message[ANSWER];
  struct nlmsghdr head;
  for (;;) {
    struct link_state state = {.bus = {BUS_UNKNOWN, -1, -1}};
    const ssize_t n = recv(netlink, message, sizeof message, MSG_DONTWAIT);
    if (n < 0) return errno == ENOBUFS ? -1 : 0;
    if (take_message(message, (size_t)n, &head, &state) != 0) continue;
    *event = (struct link_event){head.nlmsg_type == RTM_DELLINK, state};
    return 1;
  }
}

/* ---- stamps ------------------------------------------------------------------------ */

static int device_control(const char *name, unsigned long request, void *data) {
  struct ifreq ask_device;
  memset(&ask_device, 0, sizeof ask_device);
  memcpy(ask_device.ifr_name, name, strnlen(name, sizeof ask_device.ifr_name - 1));
  ask_device.ifr_data = data;
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return -1;
  const int result = ioctl(fd, request, &ask_device);
  close(fd);
  return result;
}

int link_has_hardware_stamps(const char *name) {
  struct ethtool_ts_info info = {.cmd = ETHTOOL_GET_TS_INFO};
  if (device_control(name, SIOCETHTOOL, &info) != 0) return 0;
  return (info.so_timestamping & SOF_TIMESTAMPING_RX_HARDWARE) != 0;
}

void link_ask_hardware_stamps(int index, struct link_stamps *before) {
  struct hwtstamp_config now = {.tx_type = HWTSTAMP_TX_OFF};
  char name[IF_NAMESIZE];
  *before = (struct link_stamps){.index = index};
  if (!if_indextoname((unsigned)index, name)) return;
  const int known = device_control(name, SIOCGHWTSTAMP, &now) == 0;
  struct hwtstamp_config wanted = {.tx_type = now.tx_type, .rx_filter = HWTSTAMP_FILTER_ALL};
  before->tx_type = now.tx_type;
  before->rx_filter = now.rx_filter;
  if (known && now.rx_filter == HWTSTAMP_FILTER_ALL) return;
  before->asked = device_control(name, SIOCSHWTSTAMP, &wanted) == 0 && known;
}

void link_restore_stamps(const struct link_stamps *before) {
  struct hwtstamp_config config = {.tx_type = before->tx_type, .rx_filter = before->rx_filter};
  char name[IF_NAMESIZE];
  if (before->asked && if_indextoname((unsigned)before->index, name))
    device_control(name, SIOCSHWTSTAMP, &config);
}

/* ---- names ------------------------------------------------------------------------- */

/* each CAN interface, until `each` answers 0 */
static void each_can(int netlink, int (*each)(void *into, const struct link_state *state), void *into) {
  struct if_nameindex *all = if_nameindex();
  for (struct if_nameindex *i = all; netlink >= 0 && i && i->if_index; i++) {
    struct link_state state;
    if (link_query(netlink, i->if_name, &state) == 0 && state.is_can && !each(into, &state)) break;
  }
  if (all) if_freenameindex(all);
}

struct indices {
  int *index, count, most;
};

static int add_index(void *into, const struct link_state *state) {
  struct indices *list = into;
  if (list->count < list->most) list->index[list->count++] = state->index;
  return list->count < list->most;
}

int link_all_can(int netlink, int *index, int n) {
  struct indices list = {index, 0, n};
  each_can(netlink, add_index, &list);
  return list.count;
}

struct names {
  char *out;
  size_t used, size;
};

static int add_name(void *into, const struct link_state *state) {
  struct names *list = into;
  if (list->used + LINK_NAME + 2 > list->size) return 0;
  list->used += (size_t)snprintf(list->out + list->used, list->size - list->used, "%s%s",
                                 list->used ? ", " : "", state->name);
  return 1;
}

void link_list(char *out, size_t size) {
  struct names list = {out, 0, size};
  const int netlink = link_open(0);
  snprintf(out, size, "none");
  each_can(netlink, add_name, &list);
  if (netlink >= 0) close(netlink);
}
