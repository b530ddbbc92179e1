/* can_text.c: candump's log format, one line a frame. */
#include "can_text.h"

#include <string.h>

static const char digit[] = "0123456789ABCDEF";

enum { STANDARD_DIGITS = 3, EXTENDED_DIGITS = 8, SECONDS_DIGITS = 10, MICRO_DIGITS = 6 };

size_t can_text_hex(char *out, const uint8_t *byte, size_t n) {
  for (size_t i = 0; i < n; i++) {
    out[2 * i] = digit[byte[i] >> 4];
    out[2 * i + 1] = digit[byte[i] & 15];
  }
  return 2 * n;
}

static size_t put_id(char *out, uint32_t id) {
  const int digits = id & CAN_EFF_FLAG ? EXTENDED_DIGITS : STANDARD_DIGITS;
  uint32_t rest = id & (id & CAN_EFF_FLAG ? CAN_EFF_MASK : CAN_SFF_MASK);
  for (int i = digits - 1; i >= 0; i--, rest >>= 4) out[i] = digit[rest & 15];
  return (size_t)digits;
}

static void put_decimal(char *out, int digits, uint64_t value) {
  for (int i = digits - 1; i >= 0; i--, value /= 10) out[i] = (char)('0' + value % 10);
}

/* "(seconds.microseconds) ", cut and not rounded, as candump does */
static size_t put_stamp(char *out, int64_t stamp_ns) {
  const uint64_t micro = stamp_ns > 0 ? (uint64_t)stamp_ns / 1000 : 0;
  size_t n = 0;
  out[n++] = '(';
  put_decimal(out + n, SECONDS_DIGITS, micro / 1000000);
  n += SECONDS_DIGITS;
  out[n++] = '.';
  put_decimal(out + n, MICRO_DIGITS, micro % 1000000);
  n += MICRO_DIGITS;
  out[n++] = ')';
  out[n++] = ' ';
  return n;
}

static size_t put_payload(char *out, const struct item *frame) {
  size_t n = 0;
  out[n++] = '#';
  if (frame->flags & ITEM_FD) {
    out[n++] = '#';
    out[n++] = digit[frame->flags & ITEM_FLAGS];
  } else if (frame->id & CAN_RTR_FLAG) {
    out[n++] = 'R';
    if (frame->length) out[n++] = digit[frame->length & 15];
    return n;
  }
  return n + can_text_hex(out + n, frame->is.data, frame->length);
}

size_t can_text_line(char out[CAN_LINE], const struct item *frame, int64_t stamp_ns, const char *interface) {
  size_t n = put_stamp(out, stamp_ns);
  while (*interface) out[n++] = *interface++;
  out[n++] = ' ';
  n += put_id(out + n, frame->id);
  n += put_payload(out + n, frame);
  out[n++] = '\n';
  return n;
}

/* ---- the other way ------------------------------------------------------------ */

static int value_of(char c) {
  const char upper = (char)(c >= 'a' && c <= 'f' ? c - 'a' + 'A' : c);
  const char *at = c ? strchr(digit, upper) : NULL;
  return at ? (int)(at - digit) : -1;
}

static int parse_id(const char *text, size_t n, uint32_t *id) {
  *id = 0;
  if (n != STANDARD_DIGITS && n != EXTENDED_DIGITS) return -1;
  for (size_t i = 0; i < n; i++) {
    const int value = value_of(text[i]);
    if (value < 0) return -1;
    *id = *id << 4 | (uint32_t)value;
  }
  if (*id > (n == STANDARD_DIGITS ? CAN_SFF_MASK : CAN_EFF_MASK)) return -1;
  if (n == EXTENDED_DIGITS) *id |= CAN_EFF_FLAG;
  return 0;
}

int can_text_parse(const char *text, struct can_frame *frame) {
  const char *data = strchr(text, '#');
  memset(frame, 0, sizeof *frame);
  if (!data || parse_id(text, (size_t)(data - text), &frame->can_id) != 0) return -1;
  const size_t length = strlen(++data);
  if (length % 2 != 0 || length > 2 * CAN_MAX_DLEN) return -1;
  for (size_t i = 0; i < length; i += 2) {
    const int high = value_of(data[i]), low = value_of(data[i + 1]);
    if (high < 0 || low < 0) return -1;
    frame->data[i / 2] = (__u8)(high << 4 | low);
  }
  frame->can_dlc = (__u8)(length / 2);
  return 0;
}
