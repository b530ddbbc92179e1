/* csv_file.c: a whole file of few rows, from its first line to its last. */
#include <stdlib.h>
#include <string.h>

#include "csv.h"
#include "text_file.h"

/* A file on its way in. */
struct reading {
  struct csv_lines lines;
  const struct csv_visitor *visitor;
  void *context;
  double row[CSV_MAX_COLUMNS];
};

const char *csv_skip_mark(const char *text, size_t length) {
  return length >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? text + 3 : text;
}

int csv_endless(const struct csv_lines *lines, struct app_error *error) {
  return app_fail(error, APP_BAD_INPUT, "%s:%zu: longer than %d bytes, not a line of text",
                  lines->header->path, lines->line, TEXT_BLOCK);
}

static int take_line(struct reading *r, const char *c, const char *newline, int cut,
                     struct app_error *error) {
  switch (csv_take(&r->lines, c, newline, cut, r->row, error)) {
  case CSV_NOTHING: return 0;
  case CSV_HEADER: return r->visitor->header(&r->lines, r->context, error);
  case CSV_ROW: return r->visitor->row(&r->lines, r->row, r->context, error);
  default: return -1;
  }
}

static int take_block(struct reading *r, const struct text_block *block, struct app_error *error) {
  const char *c = block->text, *end = c + block->length;
  if (block->endless) return csv_endless(&r->lines, error);
  if (r->lines.line == 1) c = csv_skip_mark(c, block->length);
  for (; c < end; r->lines.line++) {
    const char *newline = memchr(c, '\n', (size_t)(end - c));
    if (take_line(r, c, newline, newline + 1 == end && block->unterminated, error) != 0) return -1;
    c = newline + 1;
  }
  return 0;
}

static int take_file(struct reading *r, struct text_file *file, struct app_error *error) {
  struct text_block *block = malloc(sizeof *block);
  int more, result = 0;
  if (!block) return app_fail(error, APP_FAILED, "out of memory");
  while (result == 0 && (more = text_file_read(file, block, error)) != 0)
    result = more > 0 ? take_block(r, block, error) : -1;
  free(block);
  return result;
}

int csv_read(struct csv_header *header, const struct csv_visitor *visitor, void *context,
             struct app_error *error) {
  struct reading r = {.lines = {.header = header, .line = 1}, .visitor = visitor, .context = context};
  struct text_file *file = text_file_open(header->path, error);
  if (!file) return -1;
  header->fields = 0;
  const int result = take_file(&r, file, error);
  text_file_close(file);
  return result == 0 ? csv_begun(&r.lines, error) : -1;
}

int csv_begun(const struct csv_lines *lines, struct app_error *error) {
  const struct csv_header *h = lines->header;
  if (h->fields) return 0;
  if (lines->line == 1) return app_fail(error, APP_BAD_INPUT, "%s: the file is empty", h->path);
  return app_fail(error, APP_BAD_INPUT, "%s: no header line in %zu lines", h->path, lines->line - 1);
}
