/* recording_parse.c: from text to rows in a spool, on every processor.
 *
 * Each worker takes the next block of lines, turns them into numbers, and waits
 * for its turn to add them to the recording, in the order of the file: there time
 * is checked across blocks and lines are numbered, so the first fault of the file
 * is the one that is told. A block is nearly always nothing but plain rows; from the first
 * line on that is anything else, it is read in the worker's turn.
 */
#include "recording_parse.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common/progress.h"
#include "common/text_file.h"
#include "common/workers.h"
#include "recording.h"
#include "step_median.h"

#define LEAST_STEP_S 1e-7 /* no bench samples faster; times in another unit do not pass for seconds */

/* a number takes at least two bytes of text, itself and what follows it */
#define BLOCK_NUMBERS (TEXT_BLOCK / 2 + TL_CHANNEL_COUNT)

/* The file as a whole. */
struct parser {
  struct recording *recording;
  pthread_mutex_t reading; /* of file, ended and blocks */
  struct text_file *file;
  int ended;
  size_t blocks; /* handed out */
  struct progress progress;

  pthread_mutex_t adding; /* of all that follows */
  pthread_cond_t next_turn;
  size_t turn; /* the block that may be added now */
  int failed;
  struct app_error error; /* when failed */
  struct step_median *median;
  struct csv_lines lines;
  int unterminated;
};

/* One block on its way. */
struct worker {
  struct parser *parser;
  struct text_block block;
  size_t rows;
  double row[BLOCK_NUMBERS];
};

/* ---- one line, in its turn ----------------------------------------------- */

static int check_valid(const struct parser *p, const double *row, struct app_error *error) {
  const struct csv_header *header = p->lines.header;
  const int place = header->place_of[TL_CHANNEL_VALID];
  if (place < 0 || row[place] == 0.0 || row[place] == 1.0) return 0;
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: valid: %g, expected 0 or 1", header->path, p->lines.line,
                  row[place]);
}

static int check_time(const struct parser *p, double t_s, struct app_error *error) {
  const struct recording *r = p->recording;
  if (r->rows == 0 || t_s > r->last_s) return 0;
  if (t_s == r->last_s)
    return app_fail(error, APP_BAD_INPUT, "%s:%zu: time_s stands still at %.15g, it must rise%s",
                    p->lines.header->path, p->lines.line, t_s, csv_advice(p->lines.header));
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: time_s runs back from %.15g to %.15g, it must rise%s",
                  p->lines.header->path, p->lines.line, r->last_s, t_s, csv_advice(p->lines.header));
}

/* a row becomes the next sample */
static int add_sample(struct parser *p, const double *row, struct app_error *error) {
  struct recording *r = p->recording;
  const double t_s = row[p->lines.header->place_of[TL_CHANNEL_TIME]];
  if (check_time(p, t_s, error) != 0 || check_valid(p, row, error) != 0) return -1;
  if (r->rows == 0)
    r->first_s = t_s;
  else
    step_median_add(p->median, t_s - r->last_s);
  r->last_s = t_s;
  r->rows++;
  return 0;
}

/* the header has been read */
static int begin_rows(struct parser *p, struct app_error *error) {
  struct recording *r = p->recording;
  if (layout_check(&r->layout, p->lines.line, error) != 0) return -1;
  r->spool = spool_open(p->lines.header->width, error);
  return r->spool ? 0 : -1;
}

/* any line [line, newline); `cut`: the file ends here and should not */
static int read_line(struct worker *w, const char *line, const char *newline, int cut,
                     struct app_error *error) {
  struct parser *p = w->parser;
  double *row = w->row + w->rows * p->lines.header->width;
  switch (csv_take(&p->lines, line, newline, cut, row, error)) {
  case CSV_NOTHING: return 0;
  case CSV_HEADER: return begin_rows(p, error);
  case CSV_ROW: w->rows++; return add_sample(p, row, error);
  default: return -1;
  }
}

/* ---- one block ----------------------------------------------------------- */

/* plain rows from the block's beginning, without regard to what came before it; where they end */
static const char *read_plain_rows(struct worker *w) {
  const struct csv_header *header = &w->parser->recording->layout.header;
  const char *c = w->block.text, *end = c + w->block.length, *next;
  w->rows = 0;
  while (c < end && (next = csv_plain_row(header, c, w->row + w->rows * header->width))) {
    w->rows++;
    c = next;
  }
  return c;
}

/* the block's plain rows, then its lines from c on */
static int add_block(struct worker *w, const char *c, struct app_error *error) {
  struct parser *p = w->parser;
  const char *end = w->block.text + w->block.length;
  if (w->rows > 0 && p->lines.blank_line) return csv_blank(&p->lines, error);
  if (w->block.endless) return csv_endless(&p->lines, error);
  for (size_t i = 0; i < w->rows; i++, p->lines.line++)
    if (add_sample(p, w->row + i * p->lines.header->width, error) != 0) return -1;
  for (; c < end; p->lines.line++) {
    const char *newline = memchr(c, '\n', (size_t)(end - c));
    if (read_line(w, c, newline, newline + 1 == end && w->block.unterminated, error) != 0) return -1;
    c = newline + 1;
  }
  p->unterminated |= w->block.unterminated;
  return 0;
}

/* ---- threads -------------------------------------------------------------- */

static void fail(struct parser *p, const struct app_error *error) {
  pthread_mutex_lock(&p->adding);
  if (!p->failed) p->error = *error;
  p->failed = 1;
  pthread_cond_broadcast(&p->next_turn);
  pthread_mutex_unlock(&p->adding);
}

/* the next block and its number: 1, 0 at the end, -1 on failure */
static int take_block(struct worker *w, size_t *number, struct app_error *error) {
  struct parser *p = w->parser;
  pthread_mutex_lock(&p->reading);
  const int more = p->ended ? 0 : text_file_read(p->file, &w->block, error);
  p->ended |= more <= 0 || w->block.endless;
  progress_update(&p->progress, text_file_fraction(p->file));
  *number = p->blocks++;
  pthread_mutex_unlock(&p->reading);
  return more;
}

/* waits until every block before this one is added; then adds it, or tells why it could not be
 * read. *at is the place of its first row. */
static int add_in_turn(struct worker *w, size_t number, int taken, const char *c, size_t *at,
                       struct app_error *error) {
  struct parser *p = w->parser;
  pthread_mutex_lock(&p->adding);
  while (p->turn != number && !p->failed) pthread_cond_wait(&p->next_turn, &p->adding);
  int result = p->failed ? 1 : 0;
  *at = p->recording->rows;
  if (!result && (taken < 0 || add_block(w, c, error) != 0)) {
    p->error = *error;
    p->failed = 1;
    result = -1;
  }
  p->turn++;
  pthread_cond_broadcast(&p->next_turn);
  pthread_mutex_unlock(&p->adding);
  return result;
}

static void work(void *argument) {
  struct worker *w = argument;
  const struct spool *spool = w->parser->recording->spool;
  struct app_error error;
  size_t number, at;
  int taken;
  while ((taken = take_block(w, &number, &error)) != 0) {
    const char *c = taken > 0 ? read_plain_rows(w) : NULL;
    if (add_in_turn(w, number, taken, c, &at, &error) != 0) break;
    if (spool_write(spool, at, w->row, w->rows, &error) != 0) {
      fail(w->parser, &error);
      break;
    }
  }
}

static struct worker *new_worker(struct parser *p) {
  struct worker *w = malloc(sizeof *w);
  if (w) w->parser = p;
  return w;
}

/* the rest of the file by this worker and others, as many as there are processors */
static void work_together(struct parser *p, struct worker *self) {
  void *worker[WORKERS_MOST] = {self};
  const int most = workers_processors();
  int n = 1;
  while (n < most && (worker[n] = new_worker(p)) != NULL) n++;
  workers_run(work, worker, n);
  while (--n > 0) free(worker[n]);
}

/* ---- the whole file ------------------------------------------------------- */

/* blocks up to the one with the header, alone: 1 when there may be more, 0, or -1 on failure */
static int begin_file(struct parser *p, struct worker *w, struct app_error *error) {
  size_t number;
  int taken;
  while ((taken = take_block(w, &number, error)) > 0) {
    const char *text = w->block.text;
    w->rows = 0;
    if (add_block(w, number == 0 ? csv_skip_mark(text, w->block.length) : text, error) != 0) return -1;
    p->turn++;
    if (p->lines.header->fields)
      return spool_write(p->recording->spool, 0, w->row, w->rows, error) == 0 ? 1 : -1;
  }
  return taken;
}

static int check_length(const struct parser *p, struct app_error *error) {
  const struct recording *r = p->recording;
  if (csv_begun(&p->lines, error) != 0) return -1;
  if (r->rows < RECORDING_MIN_ROWS)
    return app_fail(error, APP_BAD_INPUT, "%s: %zu samples, expected at least %d", p->lines.header->path,
                    r->rows, RECORDING_MIN_ROWS);
  return 0;
}

/* only of a recording that is sound: a failure is one line and nothing else */
static void print_notes(const struct parser *p) {
  const char *path = p->lines.header->path, *unknown = p->lines.header->unknown.text;
  if (unknown[0]) app_note("%s: columns not known and not read: %s", path, unknown);
  if (p->unterminated)
    app_note("%s: the last line has no newline; if the file was cut there, its last number may be wrong",
             path);
}

static int parse_file(struct parser *p, struct worker *w, struct app_error *error) {
  progress_begin(&p->progress, "reading", p->lines.header->path);
  const int more = begin_file(p, w, error);
  if (more > 0) work_together(p, w);
  progress_end(&p->progress);
  if (more < 0) return -1;
  if (p->failed) {
    *error = p->error;
    return -1;
  }
  if (check_length(p, error) != 0) return -1;
  p->recording->step_s = step_median_value(p->median);
  if (p->recording->step_s < LEAST_STEP_S)
    return app_fail(error, APP_BAD_INPUT, "%s: time_s: the median step is %g s, expected seconds",
                    p->lines.header->path, p->recording->step_s);
  print_notes(p);
  return 0;
}

static int parse_open_file(struct parser *p, struct app_error *error) {
  struct worker *w = new_worker(p);
  p->median = step_median_new();
  const int result = w && p->median ? parse_file(p, w, error) : app_fail(error, APP_FAILED, "out of memory");
  step_median_free(p->median);
  free(w);
  return result;
}

/* A folder may be a robot's log, which talus-import reads. */
static int refuse_folder(const struct csv_header *header, struct app_error *error) {
  struct stat status;
  if (stat(header->path, &status) != 0 || !S_ISDIR(status.st_mode)) return 0;
  return app_fail(error, APP_BAD_INPUT, "%s: is a directory, expected a file%s", header->path,
                  header->advice);
}

int recording_parse(struct recording *recording, struct app_error *error) {
  struct parser p = {.recording = recording, .lines = {.header = &recording->layout.header, .line = 1}};
  if (refuse_folder(p.lines.header, error) != 0) return -1;
  p.file = text_file_open(p.lines.header->path, error);
  if (!p.file) return -1;
  pthread_mutex_init(&p.reading, NULL);
  pthread_mutex_init(&p.adding, NULL);
  pthread_cond_init(&p.next_turn, NULL);
  const int result = parse_open_file(&p, error);
  pthread_cond_destroy(&p.next_turn);
  pthread_mutex_destroy(&p.adding);
  pthread_mutex_destroy(&p.reading);
  text_file_close(p.file);
  return result;
}
