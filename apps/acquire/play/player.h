/* player.h: plays a trajectory: set-points on the bus, each at its time.
 *
 * All frames are made and all limits checked before the first one is sent. The thread sleeps to absolute
 * instants; what is late is sent at once, and when it is late by more than latest_ns the playing ends.
 */
#ifndef PLAYER_H
#define PLAYER_H

#include "acquire/record/text.h"
#include "acquire/source/can_port.h"
#include "leg_bus/lateness.h"
#include "leg_bus/leg_bus.h"
#include "setpoints.h"

enum player_end {
  PLAYER_RUNS,
  PLAYER_DONE,
  PLAYER_STOPPED,
  PLAYER_TOO_LATE,
  PLAYER_REFUSED,
  PLAYER_NO_FIELD
};

/* Who makes each set-point at its time, in place of the trajectory's own: a controller. */
struct player_feed {
  double step_s, rest_s; /* rows of this step, with a rest before and behind the motion */
  void *context;
  /* The commands of a row that is due, knee first. 0, or -1: one does not fit into its field. Must not wait. */
  int (*row)(void *context, size_t row, struct leg_bus_frame frame[SETPOINT_JOINTS]);
  void (*report)(const void *context, struct text *json); /* a JSON line of its own */
  void (*print)(const void *context);
};

struct player {
  const struct player_feed *feed; /* Nullable */
  struct trajectory points;
  struct can_frame *frame; /* two a row */
  struct can_frame heartbeat;
  struct can_port port;
  int64_t start_ns; /* monotonic, of the first row */
  int64_t latest_ns;
  struct lateness late;
  size_t rows_sent;
  uint64_t refused; /* times the kernel had no room */
  int stop;         /* set by others */
  int end;          /* enum player_end */
  int hold_failure; /* errno: the closing heartbeat was not sent */
};

/* 0, or -1 with the reason: the file, the limits, the interface. Nullable: feed. */
int player_open(struct player *p, const char *file, const char *limits, const char *interface,
                const struct player_feed *feed, struct app_error *error);
void player_close(struct player *p);

/* The thread's work: from start_ns on, until the end or until `stop`; ends with the drives holding. */
void player_run(struct player *p);

const char *player_end_text(const struct player *p);
/* One JSON line, and words for people. */
void player_report(const struct player *p, struct text *json);
void player_print(const struct player *p);

#endif
