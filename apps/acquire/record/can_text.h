/* can_text.h: frames as candump writes them. */
#ifndef CAN_TEXT_H
#define CAN_TEXT_H

#include <linux/can.h>
#include <stddef.h>

#include "acquire/source/item.h"

/* the longest line: stamp, name, id, 64 bytes */
enum { CAN_LINE = 32 + 16 + 16 + 2 * ITEM_DATA };

/* "(1732214712.123456) can0 201#1122\n" into `out`; answers its length. */
size_t can_text_line(char out[CAN_LINE], const struct item *frame, int64_t stamp_ns, const char *interface);

/* "201#1122" or "001FF201#": a classic data frame. 0, or -1 when it is none. */
int can_text_parse(const char *text, struct can_frame *frame);

/* n bytes as hex digits; answers 2 n. */
size_t can_text_hex(char *out, const uint8_t *byte, size_t n);

#endif
