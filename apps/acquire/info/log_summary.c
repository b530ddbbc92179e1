/* log_summary.c: lines of candump's format, looked at without keeping them. */
#include "log_summary.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "acquire/record/series.h"

enum { BLOCK = 1 << 20, LINE = 512, SLOTS = 4 * LOG_MESSAGES, NS_PER_S = 1000000000, ID_EXTENDED = 8 };

struct reader {
  struct log_summary *summary;
  int16_t slot[SLOTS]; /* hash to 1 + index of a message */
};

struct line {
  int64_t stamp_ns;
  char name[LOG_NAME];
  uint32_t id;
  int extended, is_error, is_remote;
};

/* ---- one line ------------------------------------------------------------------------ */

static int hex_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const char lower = (char)(c | ' ');
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

/* "(1700000000.123456) "; what stands behind it, or NULL */
static const char *take_stamp(const char *at, int64_t *stamp_ns) {
  int64_t seconds = 0, ns = 0, unit = NS_PER_S;
  int digits = 0;
  if (*at++ != '(') return NULL;
  for (; *at >= '0' && *at <= '9' && digits < 10; digits++) seconds = 10 * seconds + (*at++ - '0');
  if (!digits || *at++ != '.') return NULL;
  for (; *at >= '0' && *at <= '9' && unit > 1; unit /= 10) ns = 10 * ns + (*at++ - '0');
  if (*at++ != ')' || *at++ != ' ' || seconds > INT64_MAX / NS_PER_S - 1) return NULL;
  *stamp_ns = seconds * NS_PER_S + ns * unit;
  return at;
}

static const char *take_id(const char *at, struct line *line) {
  int digits = 0;
  for (line->id = 0; hex_of(*at) >= 0 && digits < ID_EXTENDED; digits++)
    line->id = line->id << 4 | (uint32_t)hex_of(*at++);
  if ((digits != 3 && digits != ID_EXTENDED) || *at++ != '#') return NULL;
  line->is_error = digits == ID_EXTENDED && (line->id & 0x20000000U);
  line->extended = digits == ID_EXTENDED;
  line->is_remote = *at == 'R';
  return at;
}

static int parse(const char *text, struct line *line) {
  const char *at = take_stamp(text, &line->stamp_ns);
  if (!at) return -1;
  const char *space = strchr(at, ' ');
  if (!space || space == at) return -1;
  const size_t n = (size_t)(space - at) < LOG_NAME - 1 ? (size_t)(space - at) : LOG_NAME - 1;
  memset(line->name, 0, sizeof line->name);
  memcpy(line->name, at, n);
  return take_id(space + 1, line) ? 0 : -1;
}

/* ---- the count ------------------------------------------------------------------------ */

static uint32_t hash_of(const struct line *line) {
  uint32_t h = line->id * 2654435761U + (uint32_t)line->extended;
  for (const char *c = line->name; *c; c++) h = (h ^ (uint32_t)(unsigned char)*c) * 16777619U;
  return h;
}

static int is_of(const struct log_message *m, const struct line *line) {
  return m->id == line->id && m->extended == line->extended && strcmp(m->name, line->name) == 0;
}

static struct log_message *find(struct reader *r, const struct line *line) {
  struct log_summary *s = r->summary;
  uint32_t k = hash_of(line) % SLOTS;
  for (; r->slot[k]; k = (k + 1) % SLOTS)
    if (is_of(&s->message[r->slot[k] - 1], line)) return &s->message[r->slot[k] - 1];
  if (s->messages == LOG_MESSAGES) return NULL;
  struct log_message *m = &s->message[s->messages++];
  r->slot[k] = (int16_t)s->messages;
  *m = (struct log_message){.id = line->id, .extended = line->extended, .first_ns = line->stamp_ns};
  memcpy(m->name, line->name, sizeof m->name);
  m->last_ns = line->stamp_ns;
  return m;
}

static void count(struct reader *r, const struct line *line) {
  struct log_summary *s = r->summary;
  struct log_message *m = find(r, line);
  if (s->frames++ == 0) s->first_ns = s->last_ns = line->stamp_ns;
  if (line->stamp_ns < s->first_ns) s->first_ns = line->stamp_ns;
  if (line->stamp_ns > s->last_ns) s->last_ns = line->stamp_ns;
  if (!m) {
    s->uncounted++;
    return;
  }
  const int64_t silent_ns = line->stamp_ns - m->last_ns;
  if (silent_ns > m->longest_ns) {
    m->longest_ns = silent_ns;
    m->longest_at_ns = m->last_ns;
  }
  m->backwards += silent_ns < 0;
  m->frames++;
  m->last_ns = line->stamp_ns;
}

static void take_line(struct reader *r, const char *text) {
  struct log_summary *s = r->summary;
  struct line line;
  s->lines++;
  if (!*text) return;
  if (parse(text, &line) != 0) {
    if (s->no_frames++ == 0) s->first_no_frame = s->lines;
  } else if (line.is_error) {
    s->errors++;
  } else {
    s->remote += (uint64_t)line.is_remote;
    count(r, &line);
  }
}

/* ---- the file ------------------------------------------------------------------------- */

/* whole lines of block[0..n), cut to LINE characters; answers how many bytes are left over */
static size_t take_lines(struct reader *r, char *block, size_t n) {
  char *at = block, *end;
  while ((end = memchr(at, '\n', n - (size_t)(at - block)))) {
    *end = '\0';
    if (end - at > LINE) at[LINE] = '\0';
    take_line(r, at);
    at = end + 1;
  }
  const size_t left = n - (size_t)(at - block);
  memmove(block, at, left);
  return left;
}

static int is_nothing(const char *bytes, size_t n) {
  for (size_t i = 0; i < n; i++)
    if (bytes[i]) return 0;
  return 1;
}

/* a line that does not end within a block counts as one that is none, piece by piece */
static int read_all(gzFile file, struct reader *r, char *block) {
  size_t left = 0;
  int n;
  while ((n = gzread(file, block + left, (unsigned)(BLOCK - left))) > 0) {
    left = take_lines(r, block, left + (size_t)n);
    if (left < BLOCK) continue;
    r->summary->no_frames += !is_nothing(block, left);
    left = 0;
  }
  r->summary->cut |= !is_nothing(block, left);
  return n;
}

/* a file, and the files in which its recording goes on */
static int read_series(const char *log, struct reader *r, char *block) {
  char path[4096];
  for (int part = 0; series_find(path, sizeof path, log, part) == 0; part++) {
    gzFile file = gzopen(path, "rb");
    if (!file) return -1;
    const int result = read_all(file, r, block);
    gzclose(file);
    if (result < 0) return -1;
    r->summary->files++;
  }
  return 0;
}

static int by_name_and_id(const void *a, const void *b) {
  const struct log_message *x = a, *y = b;
  const int names = strcmp(x->name, y->name);
  if (names) return names;
  return x->id < y->id ? -1 : x->id > y->id;
}

struct log_summary *log_summary_read(const char *path, struct app_error *error) {
  struct reader *r = calloc(1, sizeof *r);
  char *block = malloc(BLOCK);
  if (r) r->summary = calloc(1, sizeof *r->summary);
  struct log_summary *summary = r ? r->summary : NULL;
  errno = 0;
  const int result = summary && block ? read_series(path, r, block) : -1;
  if (result < 0)
    app_fail(error, APP_BAD_INPUT, "%s: cannot be read%s%s", path, errno ? ": " : "",
             errno ? strerror(errno) : "");
  free(block);
  free(r);
  if (result < 0) {
    free(summary);
    return NULL;
  }
  qsort(summary->message, (size_t)summary->messages, sizeof summary->message[0], by_name_and_id);
  return summary;
}
