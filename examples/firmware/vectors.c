/* vectors.c: the same motion and faults on every machine, through leg_tick; prints one hash of all currents and statuses,
 * and on Cortex-M how many instructions a call takes.
 *
 * The motion is made of whole numbers alone, so that it is the same everywhere: triangles of the acceleration.
 */
#include "board.h"
#include "leg_tick.h"

#define TICKS 4000
#define COUNTS_PER_RAD 10430

/* Numerical Recipes' generator: nothing here depends on how random it is */
static uint32_t drawn = 1;
static uint32_t draw(void) {
  drawn = drawn * 1664525U + 1013904223U;
  return drawn >> 8;
}

/* a joint that accelerates one way and the other in turns of 512 ticks; in 1/1024 counts */
struct axis {
  int32_t acceleration, speed, angle;
};

static void advance(struct axis *a, uint32_t tick, int32_t rad_s2) {
  int32_t quarter = (int32_t)(tick >> 7 & 3);

  /* + - - + : back where it began after each turn */
  a->acceleration = (quarter == 0 || quarter == 3 ? rad_s2 : -rad_s2) * COUNTS_PER_RAD;
  a->speed += a->acceleration / 1000;
  a->angle += a->speed;
}

static void fill(struct leg_counts *in, const struct axis *axis, uint32_t tick) {
  int j;

  for (j = 0; j < 2; j++) {
    in->joint_count[j] = in->desired_count[j] = axis[j].angle / 1000;
    in->speed_count_s[j] = in->desired_speed_count_s[j] = axis[j].speed;
    in->desired_acceleration_count_s2[j] = axis[j].acceleration;
  }
  in->desired_counter = in->measured_counter = tick;
  in->enable = 1;
}

/* every 700 ticks a fault of 1 to 32 ticks */
static void spoil(struct leg_counts *in, uint32_t tick) {
  static uint32_t fault, left;

  if (tick % 700 == 699) {
    fault = draw() % 4;
    left = 1 + draw() % 32;
  }
  if (!left) return;
  left--;
  if (fault == 0) in->measured_counter = 0;
  if (fault == 1) in->desired_count[0] += 3000;
  if (fault == 2) in->enable = 0;
  if (fault == 3) in->speed_count_s[1] = INT32_MAX;
}

static uint32_t fold(uint32_t hash, uint32_t word) {
  int i;

  for (i = 0; i < 4; i++) hash = (hash ^ (word >> (8 * i) & 255U)) * 16777619U; /* FNV-1a */
  return hash;
}

int main(void) {
  struct axis axis[2] = {{0, 0, 0}, {0, 0, 0}};
  struct leg_counts in;
  uint32_t hash = 2166136261U, status, tick, least, most, driven = 0;
  int32_t current_mA[2];

  board_start();
  leg_start();
  for (tick = 1; tick <= TICKS; tick++) {
    advance(&axis[0], tick, 25);
    advance(&axis[1], tick, 12);
    fill(&in, axis, tick);
    spoil(&in, tick);
    status = leg_tick(&in, current_mA);
    hash = fold(fold(fold(hash, status), (uint32_t)current_mA[0]), (uint32_t)current_mA[1]);
    driven += current_mA[0] != 0;
  }
  board_counts(&least, &most);
  board_report("hash", hash);
  board_report("driven", driven);
  board_report("least", least);
  board_report("most", most);
  board_end();
  return 0;
}
