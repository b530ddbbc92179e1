/* can_batch_parts.c: apps/acquire/source/can_batch.c, and messages as the kernel would fill them in. Compiled by
 * test_can_batch.py. */
#include "../apps/acquire/source/can_batch.c"

struct given {
  int64_t software_ns, hardware_ns, plain_ns; /* -1: no such control message */
  int64_t drops;                              /* -1: none */
  uint32_t size;                              /* bytes of the message */
  uint8_t data[MESSAGE];
};

static void add(struct msghdr *m, int type, const void *content, size_t size) {
  struct cmsghdr head = {.cmsg_level = SOL_SOCKET, .cmsg_type = type, .cmsg_len = CMSG_LEN(size)};
  char *at = (char *)m->msg_control + m->msg_controllen;
  memcpy(at, &head, sizeof head);
  memcpy(at + CMSG_LEN(0), content, size);
  m->msg_controllen += CMSG_SPACE(size);
}

static struct timespec time_of(int64_t ns) {
  return (struct timespec){ns / NS_PER_S, ns % NS_PER_S};
}

/* what can_batch_item makes of it: its answer, the item, the counter of drops (77 where it is left alone) */
int parts_item(const struct given *given, struct item *item, uint32_t *drops) {
  struct can_batch *batch = can_batch_new();
  struct msghdr *m = &batch->message[0].msg_hdr;
  memset(item, 0, sizeof *item);
  m->msg_controllen = 0;
  if (given->software_ns >= 0 || given->hardware_ns >= 0) {
    struct scm_timestamping stamp;
    memset(&stamp, 0, sizeof stamp);
    if (given->software_ns >= 0) stamp.ts[0] = time_of(given->software_ns);
    if (given->hardware_ns >= 0) stamp.ts[2] = time_of(given->hardware_ns);
    add(m, SCM_TIMESTAMPING, &stamp, sizeof stamp);
  }
  if (given->plain_ns >= 0) {
    const struct timespec plain = time_of(given->plain_ns);
    add(m, SCM_TIMESTAMPNS, &plain, sizeof plain);
  }
  const uint32_t counter = (uint32_t)given->drops;
  if (given->drops >= 0) add(m, SO_RXQ_OVFL, &counter, sizeof counter);
  memcpy(batch->data[0].byte, given->data, sizeof given->data);
  batch->message[0].msg_len = given->size;
  *drops = 77;
  const int result = can_batch_item(batch, 0, item, drops);
  can_batch_free(batch);
  return result;
}
