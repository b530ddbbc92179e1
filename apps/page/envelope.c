/* envelope.c: minimum and maximum of equal stretches. */
#include "envelope.h"

#include <math.h>

void envelope_init(struct envelope *e) {
  e->width = 1;
  e->filled = e->buckets = 0;
}

static struct envelope_bucket join(struct envelope_bucket a, struct envelope_bucket b) {
  if (isnan(b.low)) return a;
  if (isnan(a.low)) return b;
  if (b.low < a.low) {
    a.low = b.low;
    a.low_t = b.low_t;
  }
  if (b.high > a.high) {
    a.high = b.high;
    a.high_t = b.high_t;
  }
  return a;
}

/* neighbours become one: half as many, twice as wide */
static void widen(struct envelope *e) {
  for (size_t i = 0; i < ENVELOPE_BUCKETS / 2; i++)
    e->bucket[i] = join(e->bucket[2 * i], e->bucket[2 * i + 1]);
  e->buckets = ENVELOPE_BUCKETS / 2;
  e->width *= 2;
}

void envelope_add(struct envelope *e, double t, double y) {
  const struct envelope_bucket one = {t, y, t, y};
  if (e->buckets > 0 && e->filled < e->width) {
    e->bucket[e->buckets - 1] = join(e->bucket[e->buckets - 1], one);
    e->filled++;
    return;
  }
  if (e->buckets == ENVELOPE_BUCKETS) widen(e);
  e->bucket[e->buckets++] = one;
  e->filled = 1;
}

size_t envelope_points(const struct envelope *e, double *t, double *y) {
  size_t n = 0;
  for (size_t i = 0; i < e->buckets; i++) {
    const struct envelope_bucket *b = &e->bucket[i];
    const int low_first = !(b->high_t < b->low_t);
    t[n] = low_first ? b->low_t : b->high_t;
    y[n++] = low_first ? b->low : b->high;
    if (b->low_t == b->high_t) continue;
    t[n] = low_first ? b->high_t : b->low_t;
    y[n++] = low_first ? b->high : b->low;
  }
  return n;
}
