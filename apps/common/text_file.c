/* text_file.c: blocks of whole lines from a plain or compressed file. */
#include "text_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#define ZLIB_BUFFER (128u * 1024u)

struct text_file {
  const char *path;
  gzFile gz;   /* reads plain files as they are */
  off_t size;  /* of the file as it stands on disk */
  size_t rest; /* bytes of the line that the last block left over */
  int ended;
  char line[TEXT_BLOCK];
};

/* the file, open; *size is its length */
static int open_for_reading(const char *path, off_t *size, struct app_error *error) {
  const int fd = open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return app_fail(error, APP_BAD_INPUT, "%s: %s", path, strerror(errno));
  struct stat status;
  const int known = fstat(fd, &status) == 0;
  *size = known ? status.st_size : 0;
  if (known && S_ISDIR(status.st_mode)) {
    close(fd);
    return app_fail(error, APP_BAD_INPUT, "%s: is a directory, expected a file", path);
  }
  return fd;
}

struct text_file *text_file_open(const char *path, struct app_error *error) {
  off_t size = 0;
  const int fd = open_for_reading(path, &size, error);
  if (fd < 0) return NULL;
  struct text_file *file = malloc(sizeof *file);
  gzFile gz = gzdopen(fd, "rb");
  if (!file || !gz) {
    if (gz)
      gzclose(gz);
    else
      close(fd);
    free(file);
    app_fail(error, APP_FAILED, "%s: out of memory", path);
    return NULL;
  }
  gzbuffer(gz, ZLIB_BUFFER);
  file->path = path;
  file->gz = gz;
  file->size = size;
  file->rest = 0;
  file->ended = 0;
  return file;
}

void text_file_close(struct text_file *file) {
  if (!file) return;
  gzclose(file->gz);
  free(file);
}

static int read_failure(const struct text_file *file, struct app_error *error) {
  int code;
  const char *text = gzerror(file->gz, &code);
  if (code == Z_BUF_ERROR)
    return app_fail(error, APP_BAD_INPUT, "%s: truncated: the compressed data end too early", file->path);
  if (code == Z_ERRNO)
    return app_fail(error, APP_BAD_INPUT, "%s: cannot be read: %s", file->path, strerror(errno));
  if (code == Z_MEM_ERROR) return app_fail(error, APP_FAILED, "%s: out of memory", file->path);
  return app_fail(error, APP_BAD_INPUT, "%s: the compressed data are damaged (%s)", file->path, text);
}

/* fills the block as far as the file goes */
static int fill(struct text_file *file, struct text_block *block, struct app_error *error) {
  const int room = (int)(TEXT_BLOCK - block->length);
  const int got = gzread(file->gz, block->text + block->length, (unsigned)room);
  if (got >= 0) block->length += (size_t)got;
  if (got == room) return 0;
  int code;
  gzerror(file->gz, &code);
  if (got < 0 || (code != Z_OK && code != Z_STREAM_END)) return read_failure(file, error);
  file->ended = 1;
  if (block->length > 0 && block->text[block->length - 1] != '\n') {
    block->unterminated = 1;
    block->text[block->length++] = '\n';
  }
  return 0;
}

/* what follows the last newline waits for the next block */
static void keep_rest(struct text_file *file, struct text_block *block) {
  size_t n = block->length;
  while (n > 0 && block->text[n - 1] != '\n') n--;
  file->rest = block->length - n;
  memcpy(file->line, block->text + n, file->rest);
  block->length = n;
}

int text_file_read(struct text_file *file, struct text_block *block, struct app_error *error) {
  block->length = file->rest;
  block->unterminated = block->endless = 0;
  memcpy(block->text, file->line, file->rest);
  file->rest = 0;
  if (!file->ended && fill(file, block, error) != 0) return -1;
  if (block->length == 0) return 0;
  keep_rest(file, block);
  block->endless = block->length == 0;
  memset(block->text + block->length, 0, TEXT_PAD);
  return 1;
}

double text_file_fraction(const struct text_file *file) {
  const off_t at = gzoffset(file->gz);
  return file->size > 0 && at > 0 ? (double)at / (double)file->size : 0.0;
}

int text_file_ended(const struct text_file *file) {
  return file->ended && file->rest == 0;
}
