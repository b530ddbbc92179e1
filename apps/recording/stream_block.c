/* stream_block.c: the memory of one block. */
#include "stream_block.h"

#include <stdlib.h>
#include <string.h>

#include "talus/identify.h"

/* the channel that tells a joint's motion */
static tl_channel angle_of(const tl_layout *l, int joint) {
  return l->position[joint] != TL_CHANNEL_COUNT ? l->position[joint] : l->velocity[joint];
}

/* which channels the regression reads */
static void used_channels(const tl_regression *r, int joints, int used[TL_CHANNEL_COUNT]) {
  const tl_layout *l = &r->layout;
  memset(used, 0, TL_CHANNEL_COUNT * sizeof *used);
  used[TL_CHANNEL_TIME] = 1;
  for (int j = 0; j < joints; j++) {
    used[angle_of(l, j)] = used[l->effort[j]] = 1;
    if (r->temperature[j] != TL_CHANNEL_COUNT) used[r->temperature[j]] = 1;
  }
  if (l->load != TL_CHANNEL_COUNT) used[l->load] = 1;
}

void stream_room_free(struct stream_room *room) {
  free(room->columns);
  free(room->memory);
  free(room->stops);
  free(room->mask);
  memset(room, 0, sizeof *room);
}

static int out_of_memory(size_t rows, struct app_error *error) {
  return app_fail(error, APP_FAILED, "out of memory for a block of %zu rows", rows);
}

static int grow_columns(struct stream_room *room, const tl_regression *r, size_t rows,
                        struct app_error *error) {
  int used[TL_CHANNEL_COUNT];
  double *at;

  free(room->columns);
  at = room->columns = malloc(TL_CHANNEL_COUNT * rows * sizeof *at);
  room->loaded = at ? rows : 0;
  if (!at) return out_of_memory(rows, error);
  used_channels(r, tl_joint_count(&r->model), used);
  for (int c = 0; c < TL_CHANNEL_COUNT; c++) {
    room->column[c] = used[c] ? at : NULL;
    if (used[c]) at += rows;
  }
  return 0;
}

int stream_room_load(struct stream_room *room, const struct stream *s, size_t from, size_t to,
                     struct app_error *error) {
  const tl_regression *r = &s->regression;

  if (to - from > room->loaded && grow_columns(room, r, to - from, error) != 0) return -1;
  if (recording_read(s->recording, from, to - from, room->column, NULL, error) != 0) return -1;
  for (int j = 0; s->rounding >= 0 && j < tl_joint_count(&r->model); j++)
    tl_round_angles(room->column[angle_of(&r->layout, j)], to - from, r->sensing[j].noise, s->rounding, j);
  return 0;
}

tl_block stream_room_block(const struct stream_room *room, size_t first, size_t n) {
  tl_block block = {.n = n, .t_s = room->column[TL_CHANNEL_TIME] + first};

  for (int c = 0; c < TL_CHANNEL_COUNT; c++)
    block.channel[c] = room->column[c] ? room->column[c] + first : NULL;
  return block;
}

int stream_room_space(struct stream_room *room, const struct stream *s, size_t rows, size_t grid,
                      struct app_error *error) {
  const tl_regression *r = &s->regression;
  const size_t joints = (size_t)tl_joint_count(&r->model);

  if (rows <= room->rows && grid <= room->grid) return 0;
  free(room->memory);
  free(room->stops);
  free(room->mask);
  room->rows = rows > room->rows ? rows : room->rows;
  room->grid = grid > room->grid ? grid : room->grid;
  room->memory = malloc(tl_regression_memory(r, room->rows, room->grid) * sizeof(double));
  room->stops = malloc(joints * room->rows * sizeof(tl_stop));
  room->mask = malloc(joints * room->grid);
  if (!room->memory || !room->stops || !room->mask) return out_of_memory(room->rows, error);
  tl_regression_space_init(&room->space, r, room->rows, room->grid, room->memory, room->stops, room->mask);
  return 0;
}
