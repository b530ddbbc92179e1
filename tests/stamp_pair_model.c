/* stamp_pair_model.c: apps/acquire/host/stamp_pair.c, whose text is given as PART, under every order in which its stores and loads may
 * take place. Compiled by test_acquire_stamps.py.
 *
 * The publisher's stores stand in program order, but that a store which is no release may come before earlier ones to other places. The
 * reader's loads are put between them: not before a load to the same place, and not before an earlier one that is an acquire. That is
 * what the orders promise on a machine whose stores are seen by all at once.
 */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { PAIRS = 2, STORES = 4 * PAIRS, LOADS = 8, NEVER_ENDS = 1000, HARDWARE = 1000 /* stamp k is 1000 k there, k here */ };

struct access {
  const void *at;
  int64_t value;
  int order, time; /* of a load: behind so many stores */
};

static struct access store[STORES], load[LOADS];
static int order_of[STORES]; /* which store is made as the n-th */
static int stores, loads, publishing;
static int choice[LOADS], choices[LOADS];
static long executions, again, none;

static int fail(const char *what) {
  printf("violation: %s after %ld executions\n", what, executions);
  return 1;
}

static void note_store(const void *at, int64_t value, int order) {
  store[stores++] = (struct access){at, value, order, 0};
}

/* the last value of this place among the first `time` stores that were made */
static int64_t value_at(const void *at, int time) {
  for (int n = time - 1; n >= 0; n--)
    if (store[order_of[n]].at == at) return store[order_of[n]].value;
  return 0;
}

static int64_t publishers_own(const void *at) {
  for (int n = stores - 1; n >= 0; n--)
    if (store[n].at == at) return store[n].value;
  return 0;
}

static int64_t note_load(const void *at, int order) {
  int earliest = 0;
  if (publishing) return publishers_own(at);
  if (loads >= LOADS) return ++loads, value_at(at, STORES);
  for (int i = 0; i < loads; i++)
    if ((load[i].order == __ATOMIC_ACQUIRE || load[i].at == at) && load[i].time > earliest) earliest = load[i].time;
  choices[loads] = STORES - earliest + 1;
  load[loads] = (struct access){at, 0, order, earliest + choice[loads]};
  return value_at(at, load[loads++].time);
}

#define __atomic_store_n(at, value, order) note_store(at, value, order)
#define __atomic_load_n(at, order) (loads < NEVER_ENDS ? (__typeof__(*(at)))note_load(at, order) : 0)
#include PART

static struct stamp_pair pair;

/* pairs that are there whole behind so many stores */
static int whole_at(int time) {
  int made[PAIRS] = {0}, whole = 0;
  for (int n = 0; n < time; n++) whole += ++made[order_of[n] / 4] == 4;
  return whole;
}

/* one execution; what is wrong with it, or NULL */
static const char *execute(void) {
  int64_t hardware_ns = -1, real_ns = -1;
  loads = 0;
  const int found = stamp_pair_read(&pair, &hardware_ns, &real_ns);
  executions++;
  again += loads > 4;
  none += !found;
  if (loads >= NEVER_ENDS) return "no end";
  if (found && (hardware_ns != HARDWARE * real_ns || real_ns < 1 || real_ns > PAIRS)) return "stamps of two frames";
  return (found ? real_ns : 0) < whole_at(load[0].time) ? "an old pair" : NULL;
}

/* the next combination of choices; 0: there is none */
static int advance(void) {
  int i = (loads < LOADS ? loads : LOADS) - 1;
  while (i >= 0 && choice[i] + 1 == choices[i]) choice[i--] = 0;
  if (i < 0) return 0;
  choice[i]++;
  memset(choice + i + 1, 0, sizeof choice - sizeof *choice * (size_t)(i + 1));
  return 1;
}

static int may_be_next(int which, const int *made) {
  for (int i = 0; i < which; i++)
    if (!made[i] && (store[which].order == __ATOMIC_RELEASE || store[i].at == store[which].at)) return 0;
  return !made[which];
}

/* every order of the stores from the n-th on, and in each every execution of the reader */
static const char *explore(int n, int *made) {
  const char *wrong = NULL;
  if (n == STORES) {
    memset(choice, 0, sizeof choice);
    do wrong = execute();
    while (!wrong && advance());
    return wrong;
  }
  for (int which = 0; which < STORES && !wrong; which++) {
    if (!may_be_next(which, made)) continue;
    made[which] = 1;
    order_of[n] = which;
    wrong = explore(n + 1, made);
    made[which] = 0;
  }
  return wrong;
}

int main(void) {
  int made[STORES] = {0};
  publishing = 1;
  for (int k = 1; k <= PAIRS; k++) stamp_pair_publish(&pair, HARDWARE * k, k);
  publishing = 0;
  if (stores != STORES) return fail("not four stores for each pair");
  const char *wrong = explore(0, made);
  if (wrong) return fail(wrong);
  printf("executions %ld, read again %ld, none yet %ld\n", executions, again, none);
  return 0;
}
