/* step_median.c: median of a systematic sample. */
#include "step_median.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

struct step_median {
  uint64_t stride; /* every stride-th step is kept */
  uint64_t wait;   /* steps to pass over before the next one is kept */
  size_t n;
  double step[STEP_MEDIAN_ROOM];
};

struct step_median *step_median_new(void) {
  struct step_median *median = malloc(sizeof *median);
  if (!median) return NULL;
  /* all of the room becomes resident now, so that memory does not depend on the recording's length */
  memset(median->step, 0xff, sizeof median->step);
  median->stride = 1;
  median->wait = 0;
  median->n = 0;
  return median;
}

void step_median_free(struct step_median *median) {
  free(median);
}

/* keeps the first, third, fifth, ... of what is there */
static void halve(struct step_median *median) {
  median->n /= 2;
  for (size_t i = 0; i < median->n; i++) median->step[i] = median->step[2 * i];
  median->stride *= 2;
}

void step_median_add(struct step_median *median, double step) {
  if (median->wait > 0) {
    median->wait--;
    return;
  }
  /* a full buffer has an even number of steps, so the next one falls on the wider stride too */
  if (median->n == STEP_MEDIAN_ROOM) halve(median);
  median->step[median->n++] = step;
  median->wait = median->stride - 1;
}

/* Hoare's partition of [low, high] about a middle value: everything up to the answer is
 * at most everything after it */
static size_t partition(double *x, size_t low, size_t high) {
  const double pivot = x[low + (high - low) / 2];
  size_t i = low, j = high;
  for (;;) {
    while (x[i] < pivot) i++;
    while (x[j] > pivot) j--;
    if (i >= j) return j;
    const double other = x[i];
    x[i++] = x[j];
    x[j--] = other;
  }
}

/* the k-th smallest of n, k from 0; those before it in x are at most as large */
static double select_kth(double *x, size_t n, size_t k) {
  size_t low = 0, high = n - 1;
  while (low < high) {
    const size_t split = partition(x, low, high);
    if (k <= split)
      high = split;
    else
      low = split + 1;
  }
  return x[k];
}

double step_median_value(struct step_median *median) {
  const size_t n = median->n;
  if (n == 0) return 0.0;
  const double upper = select_kth(median->step, n, n / 2);
  if (n % 2) return upper;
  double lower = median->step[0];
  for (size_t i = 1; i < n / 2; i++)
    if (median->step[i] > lower) lower = median->step[i];
  return 0.5 * (lower + upper);
}
