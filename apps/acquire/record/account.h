/* account.h: every frame of a source, from the kernel to the disk; at the end the account must balance.
 *
 *     what the kernel had = read + lost in the socket
 *     read                = frames + error frames + no frames + of other interfaces
 *     frames              = written + abandoned + not written     (edges likewise)
 *     written             = synced + not synced
 *
 * Each figure is counted where it happens, by one thread; so a difference is a frame that vanished without a word, an error
 * of this program.
 */
#ifndef ACCOUNT_H
#define ACCOUNT_H

#include <stdint.h>

struct account {
  uint64_t read, frames, errors, malformed, foreign;
  uint64_t lost[2];     /* by enum item_where; of GPIO lines lost[0] */
  uint64_t written;     /* whole lines handed to the kernel */
  uint64_t synced;      /* of them, on the disk: its own word */
  uint64_t not_written; /* had, and in no file */
  uint64_t perhaps_lost,
      not_known; /* where interfaces vanished: frames at most, and interfaces without a count */
};

/* Frames without a place in this account; 0: it balances. */
uint64_t account_difference(const struct account *a);
/* Lost to the user: by the kernel, on the way to the disk, without a place. */
uint64_t account_lost(const struct account *a);

#endif
