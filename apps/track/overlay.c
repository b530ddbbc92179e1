/* overlay.c: see overlay.h. */
#include "track/overlay.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define WHOLE 0x30d158u
#define PARTIAL 0xff9f0au
#define LOST 0xff453au
#define PAPER 0xffffffu
#define CELL 640 /* about how wide a picture of the sheet is */
#define APART_S 0.1

void overlay_begin(struct overlay *o, const struct setup *setup, const char *video_path,
                   const char *sheet_path, double rate_hz) {
  memset(o, 0, sizeof *o);
  o->setup = setup;
  o->video_path = video_path;
  o->sheet_path = sheet_path;
  o->rate_hz = rate_hz;
  memcpy(o->last, setup->mark.start_px, sizeof o->last); /* until it is seen */
}

/* ---- drawing ----------------------------------------------------------------- */

static void draw_cross(const struct face_picture *p, const double at[2], double reach) {
  const double a[2] = {at[0] - reach, at[1] - reach}, b[2] = {at[0] + reach, at[1] + reach};
  const double c[2] = {at[0] - reach, at[1] + reach}, d[2] = {at[0] + reach, at[1] - reach};
  face_line(p, a, b, LOST);
  face_line(p, c, d, LOST);
}

/* 0 whole, 1 partly hidden, 2 lost */
static int draw_marker(struct overlay *o, const struct face_picture *p, int m,
                       const tl_marker_sample *sample) {
  const double radius = o->setup->mark.radius_px[m];
  double *at = o->last[m];
  const int seen = sample->flags & TL_MARKER_SEEN;
  const int partial = sample->flags & (TL_MARKER_PARTIAL | TL_MARKER_EDGE);
  if (seen) {
    at[0] = sample->x_px;
    at[1] = sample->y_px;
    face_circle(p, at[0], at[1], radius + 4.0, partial ? PARTIAL : WHOLE);
    face_circle(p, at[0], at[1], 1.0, PAPER);
  } else {
    draw_cross(p, at, radius);
  }
  const char *word = seen ? (partial ? " partly hidden" : "") : " lost";
  char text[64];
  snprintf(text, sizeof text, "%s%s", o->setup->name[m], word);
  face_label(p, at[0] + radius + 8.0, at[1] - 6.0, text, seen ? (partial ? PARTIAL : WHOLE) : LOST);
  return seen ? (partial ? 1 : 0) : 2;
}

static void draw_link(const struct overlay *o, const struct face_picture *p, int link, int valid) {
  if (valid) face_line(p, o->last[2 * link], o->last[2 * link + 1], PAPER);
}

static int draw(struct overlay *o, const struct face_picture *p, const struct track_row *row) {
  char text[120];
  int worst = 0;
  for (int m = 0; m < o->setup->mark.markers; m++) {
    const int kind = draw_marker(o, p, m, &row->sample[m]);
    if (kind > worst) worst = kind;
  }
  int used = snprintf(text, sizeof text, "%.3f s", row->t_s);
  if (o->setup->is_leg) {
    draw_link(o, p, 0, row->angles.shank_valid);
    draw_link(o, p, 1, row->angles.foot_valid);
    if (row->angles.shank_valid)
      used += snprintf(text + used, sizeof text - (size_t)used, "   shank %+.4f rad", row->angles.shank_rad);
    if (row->angles.foot_valid)
      snprintf(text + used, sizeof text - (size_t)used, "   foot %+.4f rad", row->angles.foot_rad);
  }
  face_label(p, 14.0, 28.0, text, PAPER);
  return worst;
}

/* ---- the sheet ---------------------------------------------------------------- */

/* every n-th pixel each way, as the mean of n by n */
static int shrink(const struct face_picture *p, struct face_picture *out, struct app_error *error) {
  const int n = p->width > CELL ? (p->width + CELL / 2) / CELL : 1;
  *out = (struct face_picture){NULL, (size_t)3 * (size_t)(p->width / n), p->width / n, p->height / n, p->t_s};
  out->pixel = malloc(out->stride * (size_t)out->height + 1);
  if (!out->pixel) return app_fail(error, APP_FAILED, "out of memory");
  for (int y = 0; y < out->height; y++)
    for (int x = 0; x < 3 * out->width; x++) {
      unsigned sum = 0;
      for (int k = 0; k < n * n; k++)
        sum += p->pixel[(size_t)(y * n + k / n) * p->stride + (size_t)(3 * (x / 3 * n + k % n) + x % 3)];
      out->pixel[(size_t)y * out->stride + (size_t)x] = (uint8_t)(sum / (unsigned)(n * n));
    }
  return 0;
}

static int keep(struct overlay *o, const struct face_picture *p, int kind, struct app_error *error) {
  const int n = o->count[kind];
  if (!o->sheet_path || n == OVERLAY_EACH || (n > 0 && p->t_s < o->kept_s[kind] + APART_S)) return 0;
  if (shrink(p, &o->kept[kind][n], error) != 0) return -1;
  o->kept_s[kind] = p->t_s;
  o->count[kind]++;
  return 0;
}

/* the ending stays, by which OpenCV chooses the format */
static void name_temporary(struct overlay *o, const char *path) {
  const char *slash = strrchr(path, '/');
  const int folder = slash ? (int)(slash - path + 1) : 0;
  snprintf(o->temporary, sizeof o->temporary, "%.*s.%ld.%s", folder, path, (long)getpid(), path + folder);
}

static int move(const struct overlay *o, const char *path, struct app_error *error) {
  if (rename(o->temporary, path) == 0) return 0;
  remove(o->temporary);
  return app_fail(error, APP_FAILED, "%s: cannot be written", path);
}

static int write_sheet(struct overlay *o, struct app_error *error) {
  struct face_picture all[OVERLAY_KINDS * OVERLAY_EACH];
  char text[FACE_TEXT];
  int n = 0;
  for (int kind = 0; kind < OVERLAY_KINDS; kind++)
    for (int i = 0; i < o->count[kind]; i++) all[n++] = o->kept[kind][i];
  if (n == 0) return 0;
  name_temporary(o, o->sheet_path);
  if (face_write_sheet(o->temporary, all, n, 2, text) != 0)
    return app_fail(error, APP_FAILED, "%s: %s", o->sheet_path, text);
  return move(o, o->sheet_path, error);
}

/* ---- the way through a film ----------------------------------------------------- */

static int open_writer(struct overlay *o, const struct face_picture *p, struct app_error *error) {
  char text[FACE_TEXT];
  name_temporary(o, o->video_path);
  o->writer = face_writer_open(o->temporary, o->rate_hz, p->width, p->height, text);
  if (!o->writer) return app_fail(error, APP_FAILED, "%s: %s", o->video_path, text);
  return 0;
}

int overlay_add(struct overlay *o, const struct face_picture *p, const struct track_row *row,
                struct app_error *error) {
  if (!o->video_path && !o->sheet_path) return 0;
  const int kind = draw(o, p, row);
  if (o->video_path && !o->writer && open_writer(o, p, error) != 0) return -1;
  if (o->writer) face_writer_add(o->writer, p);
  return keep(o, p, kind, error);
}

int overlay_commit(struct overlay *o, struct app_error *error) {
  if (o->writer) {
    face_writer_close(o->writer);
    o->writer = NULL;
    if (move(o, o->video_path, error) != 0) return -1;
  }
  return o->sheet_path ? write_sheet(o, error) : 0;
}

void overlay_end(struct overlay *o) {
  if (o->writer) {
    face_writer_close(o->writer);
    remove(o->temporary);
  }
  for (int kind = 0; kind < OVERLAY_KINDS; kind++)
    for (int i = 0; i < o->count[kind]; i++) free(o->kept[kind][i].pixel);
}
