/* stream.h: a recording walked through block by block, in bounded memory.
 *
 *     struct stream *stream = stream_open(recording, &model, &score, NULL, &error);
 *     stream_rows(stream, fold, &factors, &error);
 *     stream_close(stream);
 *
 * Each block comes with enough rows on either side that what is computed of its own part
 * does not depend on where the recording was cut. Blocks are computed on several processors at once, and visited
 * one after the other in the order of time: results are the same bits for any number of processors.
 */
#ifndef STREAM_H
#define STREAM_H

#include "common/error.h"
#include "recording.h"
#include "talus/experimental/regression.h"

struct stream;

/* One block as the visitor sees it. */
struct stream_part {
  const tl_regression *regression;
  tl_regression_space *space;
  size_t first;      /* the recording's row that is the block's row 0 */
  size_t begin, end; /* the recording's rows that are this part's own */
  int opens_segment; /* 1: `begin` is the first row of a segment */
  const double *t_s; /* times of the block's rows */
};

/* Called for every part in order of time, now on one thread and now on another, never on two at once; anything but 0 ends the walk and is its result. */
typedef int (*stream_visit)(const struct stream_part *part, void *context, struct app_error *error);

/* Finds the recording's segments and measures how its angles are read; NULL on failure.
 * The recording and the model file's score are kept by reference. Nullable: window (then it
 * is chosen from the data). A recording without a usable segment is bad input. */
struct stream *stream_open(struct recording *recording, const tl_model *model, const tl_score_settings *score,
                           const tl_window *window, struct app_error *error);
/* An excerpt's stream, read as the whole recording's is: same windows, noise and effects. NULL on failure. */
struct stream *stream_open_as(const struct stream *whole, struct recording *excerpt, struct app_error *error);
/* Nullable: stream. */
void stream_close(struct stream *stream);

/* Processors that a walk uses, at most WORKERS_MOST (workers.h); as many as there are without this call. */
void stream_set_workers(struct stream *stream, int workers);

/* What a walk is for, as its progress is shown; kept by reference ("computing" without this call). */
void stream_set_task(struct stream *stream, const char *task);

/* Effects that are modelled already; kept by reference. */
int stream_set_effects(struct stream *stream, const tl_effect *effect, int effects, struct app_error *error);

/* From now on, read with windows so many times as long as when it was opened (1), and the angles rounded (tl_round_angles;
 * rounding -1: as they were recorded). */
void stream_reread(struct stream *stream, double window_factor, int rounding);

const tl_regression *stream_regression(const struct stream *stream);
/* The recording's path, as recording_open was given it. */
const char *stream_path(const struct stream *stream);

/* Every part with its scored rows (space->rows), or with motion and regressor alone (space->track, raw). */
int stream_rows(struct stream *stream, stream_visit visit, void *context, struct app_error *error);
int stream_motion(struct stream *stream, stream_visit visit, void *context, struct app_error *error);

#endif
