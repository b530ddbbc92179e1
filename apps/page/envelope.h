/* envelope.h: a series of any length as the lowest and highest value of at most ENVELOPE_BUCKETS
 * stretches, in bounded memory: what a chart of it can show.
 *
 *     static struct envelope e;   (32 KiB)
 *     envelope_init(&e);
 *     for each sample: envelope_add(&e, t_s, torque_Nm);
 *     size_t n = envelope_points(&e, t, y);
 *
 * Every stretch holds the same number of samples, a power of two that doubles when
 * the room is full. A sample of NaN stands for "nothing here": a stretch of nothing
 * else is a gap.
 */
#ifndef ENVELOPE_H
#define ENVELOPE_H

#include <stddef.h>

#define ENVELOPE_BUCKETS 1000                  /* even */
#define ENVELOPE_POINTS (2 * ENVELOPE_BUCKETS) /* points at most */

struct envelope_bucket {
  double low_t, low, high_t, high; /* low is NaN while the bucket holds nothing but NaN */
};

struct envelope {
  size_t width;   /* samples of a full bucket */
  size_t filled;  /* samples in the last one */
  size_t buckets; /* in use */
  struct envelope_bucket bucket[ENVELOPE_BUCKETS];
};

void envelope_init(struct envelope *e);
void envelope_add(struct envelope *e, double t, double y);
/* Points in order of time, one for a bucket of one value or a gap (y is NaN), otherwise two:
 * how many were written to t and y, arrays of ENVELOPE_POINTS. */
size_t envelope_points(const struct envelope *e, double *t, double *y);

#endif
