/* can_batch.h: many frames with one call of the kernel, and what comes with each. */
#ifndef CAN_BATCH_H
#define CAN_BATCH_H

#include <stdint.h>

#include "item.h"

enum { CAN_BATCH = 64 };

struct can_batch;

/* NULL without memory; every page is touched. */
struct can_batch *can_batch_new(void);
void can_batch_free(struct can_batch *batch);

/* Receives what is there, at most CAN_BATCH messages; 0 nothing, -1 with errno. Never waits. */
int can_batch_receive(struct can_batch *batch, int fd);

/* Bytes of the i-th message; 0: the other end of an inherited socket is closed. */
unsigned can_batch_size(const struct can_batch *batch, int i);

/* The interface that the i-th message came by; 0 for an inherited socket. */
int can_batch_interface(const struct can_batch *batch, int i);

/* Was the i-th message sent by this machine? */
int can_batch_is_own(const struct can_batch *batch, int i);

/* The i-th message as an item (kind, length, flags, id, data, both stamps; real_ns 0 without software
 * stamp). 0, or -1 when it is no frame. *drops: the socket's counter as it was before this frame; left
 * alone where the kernel does not say. */
int can_batch_item(const struct can_batch *batch, int i, struct item *item, uint32_t *drops);

#endif
