/* marker_blob.c: connected pieces of one colour, from runs of rows joined by union-find. */
#include <string.h>

#include "marker_internal.h"

static int root_of(tl_marker_run *run, int i) {
  while (run[i].root != i) {
    run[i].root = run[run[i].root].root;
    i = run[i].root;
  }
  return i;
}

/* the earlier root stays */
static void join(tl_marker_run *run, int a, int b) {
  a = root_of(run, a);
  b = root_of(run, b);
  if (a < b)
    run[b].root = a;
  else
    run[a].root = b;
}

/* The runs of one row, appended at `used`; answers the new number, at most `capacity`. */
static int row_runs(const tl_marker_classes *classes, const tl_image *image, marker_window w, int y, int step,
                    int only, tl_marker_run *run, int used, int capacity) {
  const uint8_t *p = marker_pixel(image, w.x0, y);
  const size_t advance = (size_t)step * (size_t)image->channels;
  const int points = (w.x1 - w.x0 + step - 1) / step;
  int open = 0;
  for (int i = 0; i < points; i++) {
    const int x = w.x0 + i * step;
    const uint8_t c = marker_class(classes, p + (size_t)i * advance);
    if (open && c == run[used - 1].class_of) {
      run[used - 1].x1 = x;
      continue;
    }
    open = c != 0 && (only == 0 || c == only);
    if (!open) continue;
    if (used == capacity) return used;
    run[used] = (tl_marker_run){x, x, y, used, c};
    used++;
  }
  return used;
}

/* Joins the runs [from, to) of a row with those [above, from) of the row above that they touch. */
static void join_rows(tl_marker_run *run, int above, int from, int to, int step) {
  int a = above;
  for (int i = from; i < to; i++) {
    while (a < from && run[a].x1 + step < run[i].x0) a++;
    for (int b = a; b < from && run[b].x0 <= run[i].x1 + step; b++)
      if (run[b].class_of == run[i].class_of) join(run, b, i);
  }
}

static int all_runs(const tl_marker_classes *classes, const tl_image *image, marker_window w, int step,
                    int only, tl_marker_run *run, int capacity) {
  int used = 0, above = 0;
  for (int y = w.y0; y < w.y1; y += step) {
    const int from = used;
    used = row_runs(classes, image, w, y, step, only, run, used, capacity);
    join_rows(run, above, from, used, step);
    above = from;
  }
  return used;
}

static void add_run(tl_marker_blob *blob, const tl_marker_run *r, int step) {
  const int n = (r->x1 - r->x0) / step + 1;
  if (blob->pixels == 0) *blob = (tl_marker_blob){r->class_of, 0, 0.0, 0.0, r->x0, r->y, r->x1, r->y};
  blob->pixels += n;
  blob->x_px += 0.5 * n * (r->x0 + r->x1);
  blob->y_px += (double)n * r->y;
  if (r->x0 < blob->x0) blob->x0 = r->x0;
  if (r->x1 > blob->x1) blob->x1 = r->x1;
  blob->y1 = r->y;
}

/* Keeps the largest first; the smallest falls out when full. */
static int insert(tl_marker_blob *blob, int blobs, int capacity, const tl_marker_blob *one) {
  int at = blobs < capacity ? blobs : capacity - 1;
  if (blobs == capacity && blob[at].pixels >= one->pixels) return blobs;
  for (; at > 0 && blob[at - 1].pixels < one->pixels; at--) blob[at] = blob[at - 1];
  blob[at] = *one;
  return blobs < capacity ? blobs + 1 : blobs;
}

/* The runs' roots become lists: `root` of a run that is no root is then the next run of its piece. One pass
 * from the back, so that each piece is summed once however many there are. */
static int gather(tl_marker_run *run, int used, int step, tl_marker_blob *blob, int capacity) {
  int blobs = 0;
  for (int i = 0; i < used; i++) run[i].root = root_of(run, i);
  for (int i = 0; i < used; i++) {
    tl_marker_blob one = {0};
    if (run[i].root != i) continue;
    /* the pieces of a row-wise scan end soon: a piece has no run once a whole row passes without one */
    int last = run[i].y;
    for (int k = i; k < used && run[k].y <= last + step; k++)
      if (run[k].root == i) {
        add_run(&one, &run[k], step);
        last = run[k].y;
      }
    one.x_px /= one.pixels;
    one.y_px /= one.pixels;
    blobs = insert(blob, blobs, capacity, &one);
  }
  return blobs;
}

int tl_marker_blobs(const tl_marker_classes *classes, const tl_image *image, marker_window window, int step,
                    int only, tl_marker_blob *blob, int capacity, tl_marker_run *run, size_t runs) {
  const int limit = runs > 1000000 ? 1000000 : (int)runs;
  if (capacity < 1 || window.x0 >= window.x1 || window.y0 >= window.y1) return 0;
  const int used = all_runs(classes, image, window, step, only, run, limit);
  return gather(run, used, step, blob, capacity);
}

int tl_marker_find(const tl_marker_classes *classes, const tl_image *image, int step, tl_marker_blob *blob,
                   int capacity, tl_marker_run *run, size_t runs) {
  if (!classes || !blob || !run || step < 1 || step > 64 || !tl_marker_image_sound(image)) return 0;
  const marker_window whole = {0, 0, image->width, image->height};
  return tl_marker_blobs(classes, image, whole, step, 0, blob, capacity, run, runs);
}
