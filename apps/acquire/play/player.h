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
#include "setpoints.h"

enum player_end { PLAYER_RUNS, PLAYER_DONE, PLAYER_STOPPED, PLAYER_TOO_LATE, PLAYER_REFUSED };

struct player {
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

/* NULL file is none. 0, or -1 with the reason: the file, the limits, the interface. */
int player_open(struct player *p, const char *file, const char *limits, const char *interface,
                struct app_error *error);
void player_close(struct player *p);

/* The thread's work: from start_ns on, until the end or until `stop`; ends with the drives holding. */
void player_run(struct player *p);

const char *player_end_text(const struct player *p);
/* One JSON line, and words for people. */
void player_report(const struct player *p, struct text *json);
void player_print(const struct player *p);

#endif
