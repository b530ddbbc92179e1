/* can_source: a load for CAN interfaces, whose every frame carries a counter.
 *
 *     can_source rate SECONDS PER_MS INTERFACE...   PER_MS frames each millisecond, at absolute deadlines
 *     can_source plugged SECONDS PER_MS INTERFACE   the same, by whatever has the name just then; what is refused because
 *                                                   nothing has it is not sent, and its number comes next;
 *                                                   SIGINT ends it sooner
 *     can_source fast FRAMES INTERFACE...           as fast as the kernel takes them
 *
 * Frame k of an interface has identifier 0x100 + k % 9 and, in its first 4 bytes, k (little endian). What the
 * kernel refuses for want of room is tried again until it goes. Prints one line for each interface: its name,
 * the frames sent, the times it had to try again.
 */
#define _GNU_SOURCE /* sendmmsg */

#include <errno.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum {
  MOST_INTERFACES = 8,
  BATCH = 64,
  IDS = 9,
  FIRST_ID = 0x100,
  NS_PER_MS = 1000000,
  NS_PER_S = 1000000000
};

struct sender {
  const char *name;
  int fd;
  struct sockaddr_can to; /* of one that may be pulled out */
  int plugged;
  uint32_t sent;
  unsigned long again;
};

static struct sender sender[MOST_INTERFACES];

static int open_sender(struct sender *s, const char *name) {
  const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(name)};
  s->name = name;
  s->fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
  if (s->fd < 0 || !address.can_ifindex) return -1;
  setsockopt(s->fd, SOL_CAN_RAW, CAN_RAW_FILTER, NULL, 0);
  return bind(s->fd, (const struct sockaddr *)&address, sizeof address);
}

static void make_frame(struct can_frame *frame, uint32_t k) {
  memset(frame, 0, sizeof *frame);
  frame->can_id = FIRST_ID + k % IDS;
  frame->can_dlc = CAN_MAX_DLEN;
  memcpy(frame->data, &k, sizeof k);
}

static int open_plugged(struct sender *s, const char *name) {
  s->name = name;
  s->plugged = 1;
  s->to.can_family = AF_CAN;
  s->fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
  return s->fd < 0 ? -1 : setsockopt(s->fd, SOL_CAN_RAW, CAN_RAW_FILTER, NULL, 0);
}

static int is_away(void) {
  return errno == ENODEV || errno == ENXIO || errno == ENETDOWN;
}

/* n <= BATCH frames, all of them, unless it is pulled out */
static int send_frames(struct sender *s, int n) {
  static struct can_frame frame[BATCH];
  static struct iovec space[BATCH];
  static struct mmsghdr message[BATCH];
  for (int i = 0; i < n; i++) {
    make_frame(&frame[i], s->sent + (uint32_t)i);
    space[i] = (struct iovec){&frame[i], sizeof frame[i]};
    message[i] = (struct mmsghdr){.msg_hdr = {.msg_iov = &space[i], .msg_iovlen = 1}};
    if (s->plugged) message[i].msg_hdr.msg_name = &s->to;
    if (s->plugged) message[i].msg_hdr.msg_namelen = sizeof s->to;
  }
  int done = 0;
  while (done < n) {
    const int now = sendmmsg(s->fd, message + done, (unsigned)(n - done), 0);
    if (now < 0 && s->plugged && is_away()) break;
    if (now < 0 && errno != ENOBUFS && errno != EAGAIN && errno != EINTR) return -1;
    s->again += now < 0;
    if (now > 0) done += now;
  }
  s->sent += (uint32_t)done;
  return 0;
}

static int64_t now_ns(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (int64_t)t.tv_sec * NS_PER_S + t.tv_nsec;
}

static void sleep_until(int64_t ns) {
  const struct timespec t = {ns / NS_PER_S, ns % NS_PER_S};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR) continue;
}

static volatile sig_atomic_t interrupted;

static void note_interrupt(int signal) {
  (void)signal;
  interrupted = 1;
}

/* a late millisecond is made up for, so that the number of frames is what was asked for */
static int run_rate(double seconds, int per_ms, int senders) {
  const int64_t start = now_ns();
  for (int64_t ms = 0; ms < (int64_t)(seconds * 1e3) && !interrupted; ms++) {
    sleep_until(start + ms * NS_PER_MS);
    for (int i = 0; i < senders; i++) {
      if (sender[i].plugged) sender[i].to.can_ifindex = (int)if_nametoindex(sender[i].name);
      if (send_frames(&sender[i], per_ms) != 0) return -1;
    }
  }
  return 0;
}

static int run_fast(long frames, int senders) {
  for (long done = 0; done < frames; done += BATCH)
    for (int i = 0; i < senders; i++)
      if (send_frames(&sender[i], (int)(frames - done < BATCH ? frames - done : BATCH)) != 0) return -1;
  return 0;
}

int main(int argc, char **argv) {
  const int plugged = argc > 4 && strcmp(argv[1], "plugged") == 0;
  const int rate = plugged || (argc > 4 && strcmp(argv[1], "rate") == 0), first = rate ? 4 : 3,
            senders = argc - first;
  if (argc < 4 || senders < 1 || senders > MOST_INTERFACES || (!rate && strcmp(argv[1], "fast") != 0))
    return 2;
  for (int i = 0; i < senders; i++)
    if ((plugged ? open_plugged : open_sender)(&sender[i], argv[first + i]) != 0)
      return perror(argv[first + i]), 1;
  const long count = strtol(argv[rate ? 3 : 2], NULL, 10);
  if (rate && (count < 1 || count > BATCH)) return 2;
  if (plugged) signal(SIGINT, note_interrupt);
  const int result = rate ? run_rate(strtod(argv[2], NULL), (int)count, senders) : run_fast(count, senders);
  if (result != 0) perror("send");
  for (int i = 0; i < senders; i++)
    printf("%s %lu %lu\n", sender[i].name, (unsigned long)sender[i].sent, sender[i].again);
  return result != 0;
}
