/* stream_walk.c: parts of a recording, computed side by side and visited in order.
 *
 * Each walker takes the next part, loads its block, computes it, and waits for its turn to have it visited. The
 * block's margins are found in the times that were loaded with it, so the recording is read once a walk.
 */
#include <math.h>
#include <pthread.h>
#include <stdlib.h>

#include "common/progress.h"
#include "common/workers.h"
#include "stream_block.h"

#define PART_ROWS 4096 /* rows that are a block's own */
#define LEAST_ROWS 64  /* a block is not smaller, where the segment allows */
#define SPARE 1.25     /* margins are loaded so much wider than even steps would need */

/* The walk as a whole. */
struct walk {
  struct stream *stream;
  int with_rows;
  stream_visit visit;
  void *context;

  pthread_mutex_t taking; /* of the place that is handed out next */
  size_t segment, row, parts;

  pthread_mutex_t visiting; /* of all that follows */
  pthread_cond_t next_turn;
  size_t turn; /* the part that may be visited now */
  int result;  /* anything but 0 ends the walk */
  struct progress progress;
  struct app_error *error;
};

/* One part on its way. */
struct walker {
  struct walk *walk;
  struct stream_room room;
  size_t number;
  tl_segment segment;
  struct stream_part part;
  size_t low, high; /* rows that are loaded */
};

/* the next part of a segment: 1, or 0 at the end */
static int take_part(struct walker *w) {
  struct walk *walk = w->walk;
  const struct segments *all = &walk->stream->segments;
  pthread_mutex_lock(&walk->taking);
  const int more = walk->segment < all->count;
  if (more) {
    w->segment = all->segment[walk->segment];
    if (walk->row < w->segment.begin) walk->row = w->segment.begin;
    const size_t begin = walk->row, rest = w->segment.end - begin;
    const size_t end = begin + (rest < PART_ROWS ? rest : PART_ROWS);
    w->part = (struct stream_part){.regression = &walk->stream->regression,
                                   .space = &w->room.space,
                                   .begin = begin,
                                   .end = end,
                                   .opens_segment = begin == w->segment.begin};
    w->number = walk->parts++;
    walk->row = end;
    walk->segment += end == w->segment.end;
  }
  pthread_mutex_unlock(&walk->taking);
  return more;
}

/* ---- the block about a part --------------------------------------------------------------- */

static double time_at(const struct walker *w, size_t row) {
  return w->room.column[TL_CHANNEL_TIME][row - w->low];
}

/* are all rows within margin_s of the part loaded, as far as the segment has them? */
static int reaches(const struct walker *w, double margin_s) {
  const double begin_s = time_at(w, w->part.begin) - margin_s, end_s = time_at(w, w->part.end - 1) + margin_s;
  return (w->low == w->segment.begin || time_at(w, w->low) < begin_s) &&
         (w->high == w->segment.end || time_at(w, w->high - 1) >= end_s);
}

/* the part's rows and its margins; where steps are longer or shorter than the median, once more and wider */
static int load_part(struct walker *w, double margin_s, struct app_error *error) {
  const struct stream *s = w->walk->stream;
  const tl_segment all = w->segment;
  size_t margin = (size_t)(SPARE * margin_s / s->regression.step_s) + LEAST_ROWS;
  do {
    w->low = w->part.begin - all.begin > margin ? w->part.begin - margin : all.begin;
    w->high = all.end - w->part.end > margin ? w->part.end + margin : all.end;
    if (stream_room_load(&w->room, s, w->low, w->high, error) != 0) return -1;
    margin *= 2;
  } while (!reaches(w, margin_s));
  return 0;
}

/* the first row in [low, high] whose time is not below at_s; high when none is */
static size_t row_at(const struct walker *w, size_t low, size_t high, double at_s) {
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (time_at(w, middle) < at_s)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/* rows around the part's own that the block must see: from part.first on, up to the answer */
static size_t surround(struct walker *w, double margin_s) {
  struct stream_part *part = &w->part;
  const double begin_s = time_at(w, part->begin) - margin_s, end_s = time_at(w, part->end - 1) + margin_s;
  const size_t to = row_at(w, part->end, w->high, end_s), least = w->segment.begin + LEAST_ROWS;
  part->first = row_at(w, w->low, part->begin, begin_s);
  if (to - part->first < LEAST_ROWS) part->first = to > least ? to - LEAST_ROWS : w->segment.begin;
  return to;
}

/* ---- computing and visiting ---------------------------------------------------------------- */

/* where the block lies in its segment, for the grid */
static int make_span(const struct walker *w, tl_span *span, struct app_error *error) {
  struct recording *recording = w->walk->stream->recording;
  double *begin[TL_CHANNEL_COUNT] = {[TL_CHANNEL_TIME] = &span->segment_begin_s};
  double *end[TL_CHANNEL_COUNT] = {[TL_CHANNEL_TIME] = &span->segment_end_s};
  span->begin_s = time_at(w, w->part.begin);
  span->end_s = w->part.end < w->segment.end ? time_at(w, w->part.end) : HUGE_VAL;
  if (recording_read(recording, w->segment.begin, 1, begin, NULL, error) != 0) return -1;
  return recording_read(recording, w->segment.end - 1, 1, end, NULL, error);
}

static int compute(struct walker *w, struct app_error *error) {
  const struct stream *s = w->walk->stream;
  const tl_regression *r = &s->regression;
  const double margin_s = tl_regression_margin_s(r);
  tl_span span;
  size_t grid = 1;
  if (load_part(w, margin_s, error) != 0 || make_span(w, &span, error) != 0) return -1;
  const size_t to = surround(w, margin_s), n = to - w->part.first;
  if (w->walk->with_rows) grid = (size_t)((time_at(w, to - 1) - time_at(w, w->part.first)) / r->step_s) + 3;
  if (stream_room_space(&w->room, s, n, grid, error) != 0) return -1;
  const tl_block block = stream_room_block(&w->room, w->part.first - w->low, n);
  const tl_status status = w->walk->with_rows ? tl_regression_block(r, &block, &span, &w->room.space)
                                              : tl_regression_motion(r, &block, &w->room.space);
  w->part.t_s = block.t_s;
  if (status == TL_OK) return 0;
  return app_fail(error, APP_FAILED, "%s: rows %zu to %zu: %s", stream_path(s), w->part.begin, w->part.end,
                  tl_status_text(status));
}

/* waits until every part before this one has been visited: is the walk to go on? */
static int visit_in_turn(struct walker *w, int computed, const struct app_error *error) {
  struct walk *walk = w->walk;
  pthread_mutex_lock(&walk->visiting);
  while (walk->turn != w->number && !walk->result) pthread_cond_wait(&walk->next_turn, &walk->visiting);
  if (!walk->result && computed != 0) {
    walk->result = computed;
    *walk->error = *error;
  } else if (!walk->result)
    walk->result = walk->visit(&w->part, walk->context, walk->error);
  progress_update(&walk->progress, (double)w->part.end / (double)recording_rows(walk->stream->recording));
  walk->turn++;
  const int go_on = !walk->result;
  pthread_cond_broadcast(&walk->next_turn);
  pthread_mutex_unlock(&walk->visiting);
  return go_on;
}

static void work(void *argument) {
  struct walker *w = argument;
  struct app_error error;
  while (take_part(w)) {
    const int computed = compute(w, &error);
    if (!visit_in_turn(w, computed, &error)) break;
  }
}

static int walk_together(struct walk *walk, struct app_error *error) {
  void *worker[WORKERS_MOST];
  int n = 0;
  while (n < walk->stream->workers && (worker[n] = calloc(1, sizeof(struct walker))) != NULL) {
    ((struct walker *)worker[n])->walk = walk;
    n++;
  }
  if (n == 0) return app_fail(error, APP_FAILED, "out of memory");
  workers_run(work, worker, n);
  while (n-- > 0) {
    stream_room_free(&((struct walker *)worker[n])->room);
    free(worker[n]);
  }
  return walk->result;
}

static int walk(struct stream *stream, int with_rows, stream_visit visit, void *context,
                struct app_error *error) {
  struct walk walk = {
      .stream = stream, .with_rows = with_rows, .visit = visit, .context = context, .error = error};
  pthread_mutex_init(&walk.taking, NULL);
  pthread_mutex_init(&walk.visiting, NULL);
  pthread_cond_init(&walk.next_turn, NULL);
  progress_begin(&walk.progress, stream->task, stream_path(stream));
  const int result = walk_together(&walk, error);
  progress_end(&walk.progress);
  pthread_cond_destroy(&walk.next_turn);
  pthread_mutex_destroy(&walk.visiting);
  pthread_mutex_destroy(&walk.taking);
  return result;
}

int stream_rows(struct stream *stream, stream_visit visit, void *context, struct app_error *error) {
  return walk(stream, 1, visit, context, error);
}

int stream_motion(struct stream *stream, stream_visit visit, void *context, struct app_error *error) {
  return walk(stream, 0, visit, context, error);
}
