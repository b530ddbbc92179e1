/* picture.h: what talus-feedforward --twin --html shows: errors of all runs, and of the last one angles and torques.
 *
 *     struct picture *picture = picture_new(runs);
 *     for each run: picture_begin(picture); ... picture_see(picture, &instant) ...
 *     picture_write(picture, path, run, runs, &error);
 *     picture_free(picture);
 */
#ifndef PICTURE_H
#define PICTURE_H

#include "lockstep.h"

#define PICTURE_RUNS 17 /* at most */

struct picture;

/* What was run, and its figures; the first is without feedforward. */
struct picture_run {
  const char *name;
  const struct lockstep_result *result;
};

/* NULL when out of memory. */
struct picture *picture_new(int runs);
/* Nullable: picture. */
void picture_free(struct picture *picture);
/* The next run. */
void picture_begin(struct picture *picture);
/* lockstep's `see`; context is the picture. */
void picture_see(void *context, const struct lockstep_instant *at);
/* 0, or -1. */
int picture_write(const struct picture *picture, const char *path, const struct picture_run *run, int runs,
                  struct app_error *error);

#endif
