/* can_batch.c: recvmmsg, and its control messages. */
#define _GNU_SOURCE /* recvmmsg */

#include "can_batch.h"

#include <linux/can.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

#include <linux/errqueue.h> /* needs struct timespec */

#ifndef CANFD_BRS
#define CANFD_BRS 0x01
#define CANFD_ESI 0x02
#endif

/* a frame, and the stamp that a replayed one may carry behind it */
enum { STAMP = 8, MESSAGE = CANFD_MTU + STAMP, CONTROL = 256, NS_PER_S = 1000000000 };

struct can_batch {
  struct mmsghdr message[CAN_BATCH];
  struct iovec space[CAN_BATCH];
  union {
    uint8_t byte[MESSAGE];
    uint64_t aligned;
  } data[CAN_BATCH];
  union {
    char byte[CONTROL];
    size_t aligned; /* as struct cmsghdr's first member */
  } control[CAN_BATCH];
  struct sockaddr_can from[CAN_BATCH];
};

struct can_batch *can_batch_new(void) {
  struct can_batch *b = malloc(sizeof *b);
  if (!b) return NULL;
  memset(b, 0, sizeof *b);
  for (int i = 0; i < CAN_BATCH; i++) {
    b->space[i] = (struct iovec){b->data[i].byte, MESSAGE};
    b->message[i].msg_hdr.msg_iov = &b->space[i];
    b->message[i].msg_hdr.msg_iovlen = 1;
    b->message[i].msg_hdr.msg_control = b->control[i].byte;
    b->message[i].msg_hdr.msg_name = &b->from[i];
  }
  return b;
}

void can_batch_free(struct can_batch *batch) {
  free(batch);
}

int can_batch_receive(struct can_batch *batch, int fd) {
  for (int i = 0; i < CAN_BATCH; i++) {
    batch->message[i].msg_hdr.msg_controllen = CONTROL;
    batch->message[i].msg_hdr.msg_namelen = sizeof batch->from[i];
  }
  return recvmmsg(fd, batch->message, CAN_BATCH, MSG_DONTWAIT, NULL);
}

static int64_t nanoseconds(const struct timespec *t) {
  return (int64_t)t->tv_sec * NS_PER_S + t->tv_nsec;
}

static void take_control(const struct cmsghdr *c, struct item *item, uint32_t *drops) {
  if (c->cmsg_level != SOL_SOCKET) return;
  if (c->cmsg_type == SCM_TIMESTAMPING) {
    struct scm_timestamping stamp;
    memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
    if (nanoseconds(&stamp.ts[0])) item->real_ns = nanoseconds(&stamp.ts[0]);
    item->hardware_ns = nanoseconds(&stamp.ts[2]);
  } else if (c->cmsg_type == SCM_TIMESTAMPNS) {
    struct timespec stamp;
    memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
    item->real_ns = nanoseconds(&stamp);
  } else if (c->cmsg_type == SO_RXQ_OVFL) {
    memcpy(drops, CMSG_DATA(c), sizeof *drops);
  }
}

static int is_fd(size_t n) {
  return n == CANFD_MTU || n == CANFD_MTU + STAMP;
}

static int is_classic(size_t n) {
  return n == CAN_MTU || n == CAN_MTU + STAMP;
}

/* struct can_frame and struct canfd_frame have id, length, flags and data at the same places */
static int take_frame(const uint8_t *byte, size_t n, struct item *item) {
  struct canfd_frame frame;
  const size_t size = is_fd(n) ? CANFD_MTU : CAN_MTU;
  if (!is_fd(n) && !is_classic(n)) return -1;
  memset(&frame, 0, sizeof frame);
  memcpy(&frame, byte, size);
  if (frame.len > (is_fd(n) ? CANFD_MAX_DLEN : CAN_MAX_DLEN)) return -1;
  item->kind = frame.can_id & CAN_ERR_FLAG ? ITEM_ERROR : ITEM_FRAME;
  item->id = frame.can_id;
  item->length = frame.len;
  item->flags = is_fd(n) ? (uint8_t)(ITEM_FD | (frame.flags & (CANFD_BRS | CANFD_ESI))) : 0;
  memcpy(item->is.data, frame.data, sizeof frame.data);
  if (n > size) memcpy(&item->real_ns, byte + size, STAMP);
  return 0;
}

unsigned can_batch_size(const struct can_batch *batch, int i) {
  return batch->message[i].msg_len;
}

int can_batch_interface(const struct can_batch *batch, int i) {
  return batch->from[i].can_family == AF_CAN ? batch->from[i].can_ifindex : 0;
}

int can_batch_is_own(const struct can_batch *batch, int i) {
  return (batch->message[i].msg_hdr.msg_flags & MSG_DONTROUTE) != 0;
}

int can_batch_item(const struct can_batch *batch, int i, struct item *item, uint32_t *drops) {
  struct msghdr *m = (struct msghdr *)&batch->message[i].msg_hdr;
  item->real_ns = item->hardware_ns = 0;
  for (struct cmsghdr *c = CMSG_FIRSTHDR(m); c; c = CMSG_NXTHDR(m, c)) take_control(c, item, drops);
  return take_frame(batch->data[i].byte, batch->message[i].msg_len, item);
}
