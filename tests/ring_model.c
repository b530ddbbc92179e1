/* ring_model.c: every execution of a small apps/acquire/source/ring.c under C's memory model. Built and run by
 * test_acquire_ring.py:
 *
 *     ring_model ATTEMPTS POLLS AT_ONCE FIRST
 *
 * One thread tries to push ATTEMPTS items into a ring of two places, the other looks POLLS times and takes at most
 * AT_ONCE items each time. Both counters begin at FIRST, so that 2^32 can lie on the way.
 *
 * ring.c is the real one, compiled with -fsanitize=thread but linked without that sanitizer: what the compiler then
 * calls at each access to memory is answered here. Before each atomic operation a thread stops, and the search goes
 * through every choice of who is next and what a load finds:
 *
 * - A store is a message: it stays, and a load may find any message that its thread does not know to be outdated. So a
 *   store may be seen late, and a load may be early. Messages of different variables have no common order.
 * - A release store carries all that its thread knows, an acquire load takes that over. A relaxed one carries nothing.
 * - Plain accesses of two threads, one of them a write, must be ordered by that (vector clocks). If they are not, it is a
 *   data race, thus an item that may be read half-written or written over while it is read: a violation. Without one,
 *   plain accesses find the same in any order, so the search need not stop at them.
 *
 * A load never finds a store that comes later in the search. For acquires and releases alone C allows nothing else; of what
 * relaxed operations may do, this is a part, which is enough to show that they are too weak.
 *
 * Two paths to one state are followed once: each variable has one writer, so what each thread has done and which
 * messages it found determines everything. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <ucontext.h>

#include "acquire/source/ring.h"

enum { PLACES = 2, THREADS = 2, PRODUCER = 0, CONSUMER = 1, NOBODY = -1 };
enum { HEAD, TAIL, WATERMARK, VARIABLES };
enum { MESSAGES = 32, STEPS = 32, STACK = 1 << 16, CELL = 4 };
enum {
  RING_CELLS = (sizeof(struct ring) + CELL - 1) / CELL,
  CELLS = RING_CELLS + PLACES * sizeof(struct item) / CELL
};

/* What a thread knows, or a message carries: of each thread the steps that came before, of each variable the oldest
 * message that is not outdated. */
struct knowledge {
  uint8_t step[THREADS], message[VARIABLES];
};

struct message {
  uint64_t value;
  struct knowledge carries;
};

/* the step of each thread's last access of a kind; 0: none */
enum access { READ, WRITE, ATOMIC_READ, ATOMIC_WRITE, ACCESSES };
struct cell {
  uint8_t last[ACCESSES][THREADS];
};

struct thread {
  ucontext_t context;
  struct knowledge knows;
  uint8_t log[STEPS]; /* what it did: the message a load found, or STORED */
  uint8_t steps, over;
  int variable, loads; /* of the operation it stopped at */
  int finds;           /* the message it is to find */
};
enum { STORED = 0xff };

struct choice {
  uint8_t thread, message;
};

struct state {
  uint8_t log[THREADS][STEPS];
  uint8_t steps[THREADS], used;
};

static struct { uint32_t attempts, polls, at_once, first; } given;
static struct ring ring;
static struct thread thread[THREADS];
static char stack[THREADS][STACK];
static ucontext_t search;
static int running = NOBODY;
static struct message message[VARIABLES][MESSAGES];
static int messages[VARIABLES];
static struct cell cell[CELLS];

static struct { uint32_t accepted, refused, taken; } seen;

static struct { unsigned long states, ends, refusals, old_loads; } total;

/* ---- violations ------------------------------------------------------------------- */

static void violation(const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  printf("violation: ");
  vprintf(format, arguments);
  va_end(arguments);
  for (int t = 0; t < THREADS; t++) {
    printf("\n%s:", t == PRODUCER ? "producer" : "consumer");
    for (int i = 0; i < thread[t].steps; i++)
      thread[t].log[i] == STORED ? printf(" store") : printf(" load(%d)", thread[t].log[i]);
  }
  printf("\n");
  exit(1);
}

static void demand(int holds, const char *what) {
  if (!holds) violation("%s", what);
}

/* the model is too small for what it was asked: no verdict */
static void allow(int holds, const char *what) {
  if (holds) return;
  fprintf(stderr, "ring_model: too many %s\n", what);
  exit(2);
}

/* ---- memory: plain accesses --------------------------------------------------------- */

/* the first cell of an address, or -1: none of the ring's */
static int cell_of(const volatile void *address) {
  const uintptr_t at = (uintptr_t)address, fields = (uintptr_t)&ring, items = (uintptr_t)ring.item;
  if (at >= fields && at < fields + sizeof ring) return (int)((at - fields) / CELL);
  if (at >= items && at < items + PLACES * sizeof(struct item))
    return RING_CELLS + (int)((at - items) / CELL);
  return -1;
}

/* do two accesses of different threads to one cell need an order? */
static int conflict(enum access a, enum access b) {
  const int writes = a == WRITE || a == ATOMIC_WRITE || b == WRITE || b == ATOMIC_WRITE;
  const int both_atomic = a >= ATOMIC_READ && b >= ATOMIC_READ;
  return writes && !both_atomic;
}

static void touch(const volatile void *address, size_t size, enum access access) {
  const int begin = cell_of(address);
  if (running == NOBODY || begin < 0) return;
  const int other = 1 - running;
  const struct knowledge *knows = &thread[running].knows;
  for (int i = begin; i <= cell_of((const volatile char *)address + size - 1); i++) {
    for (int before = 0; before < ACCESSES; before++)
      if (conflict(access, (enum access)before) && cell[i].last[before][other] > knows->step[other])
        violation("data race in %s", i < RING_CELLS ? "the ring's fields" : "an item");
    cell[i].last[access][running] = knows->step[running];
  }
}

/* ---- memory: atomic operations ------------------------------------------------------ */

static void raise_to(uint8_t *value, uint8_t least) {
  if (*value < least) *value = least;
}

static void learn(struct knowledge *knows, const struct knowledge *more) {
  for (int t = 0; t < THREADS; t++) raise_to(&knows->step[t], more->step[t]);
  for (int v = 0; v < VARIABLES; v++) raise_to(&knows->message[v], more->message[v]);
}

static int variable_of(const volatile void *address) {
  if (address == &ring.head) return HEAD;
  if (address == &ring.tail) return TAIL;
  if (address == &ring.watermark_ns) return WATERMARK;
  violation("an atomic operation on what the model does not know");
  return -1;
}

/* lets the search choose; comes back when this thread is to do it */
static struct thread *stop_at(int variable, int loads) {
  struct thread *me = &thread[running];
  me->variable = variable;
  me->loads = loads;
  swapcontext(&me->context, &search);
  return me;
}

static void note_step(struct thread *me, int what) {
  allow(me->steps < STEPS, "steps");
  me->log[me->steps++] = (uint8_t)what;
  me->knows.step[me - thread]++;
}

static uint64_t load(const volatile void *address, size_t size, int order) {
  const int v = variable_of(address);
  struct thread *me = stop_at(v, 1);
  const struct message *found = &message[v][me->finds];
  touch(address, size, ATOMIC_READ);
  if (order != __ATOMIC_RELAXED) learn(&me->knows, &found->carries);
  raise_to(&me->knows.message[v], (uint8_t)me->finds);
  total.old_loads += me->finds < messages[v] - 1;
  note_step(me, me->finds);
  return found->value;
}

static void store(volatile void *address, size_t size, uint64_t value, int order) {
  const int v = variable_of(address);
  struct thread *me = stop_at(v, 0);
  const int at = messages[v]++;
  allow(at < MESSAGES, "stores");
  touch(address, size, ATOMIC_WRITE);
  me->knows.message[v] = (uint8_t)at;
  message[v][at].value = value;
  memset(&message[v][at].carries, 0, sizeof message[v][at].carries);
  if (order != __ATOMIC_RELAXED) message[v][at].carries = me->knows;
  note_step(me, STORED);
}

/* ---- what the compiler calls ---------------------------------------------------------- */

#define PLAIN(n)                                                                                             \
  void __tsan_read##n(void *address);                                                                        \
  void __tsan_write##n(void *address);                                                                       \
  void __tsan_read##n(void *address) {                                                                       \
    touch(address, n, READ);                                                                                 \
  }                                                                                                          \
  void __tsan_write##n(void *address) {                                                                      \
    touch(address, n, WRITE);                                                                                \
  }
PLAIN(1)
PLAIN(2)
PLAIN(4)
PLAIN(8)
PLAIN(16)

#define ATOMIC(bits, type)                                                                                   \
  type __tsan_atomic##bits##_load(const volatile type *address, int order);                                  \
  void __tsan_atomic##bits##_store(volatile type *address, type value, int order);                           \
  type __tsan_atomic##bits##_load(const volatile type *address, int order) {                                 \
    return running == NOBODY ? *address : (type)load(address, sizeof(type), order);                          \
  }                                                                                                          \
  void __tsan_atomic##bits##_store(volatile type *address, type value, int order) {                          \
    if (running != NOBODY) store(address, sizeof(type), (uint64_t)value, order);                             \
    *address = value;                                                                                        \
  }
ATOMIC(32, uint32_t)
ATOMIC(64, uint64_t)

void __tsan_read_range(void *address, size_t size);
void __tsan_write_range(void *address, size_t size);
void __tsan_init(void);
void __tsan_func_entry(void *caller);
void __tsan_func_exit(void);

void __tsan_read_range(void *address, size_t size) {
  touch(address, size, READ);
}
void __tsan_write_range(void *address, size_t size) {
  touch(address, size, WRITE);
}
void __tsan_init(void) {}
void __tsan_func_entry(void *caller) {
  (void)caller;
}
void __tsan_func_exit(void) {}

/* ---- the two threads ---------------------------------------------------------------- */

/* Item k, k = 1, 2, ... of those accepted, is stamped k; all its data say so too. */
static void push_one(void) {
  struct item item;
  memset(&item, (int)seen.accepted + 1, sizeof item);
  item.real_ns = seen.accepted + 1;
  const int taken = ring_push(&ring, &item);
  const uint64_t tail = message[TAIL][thread[PRODUCER].knows.message[TAIL]].value;
  demand(taken == (given.first + seen.accepted - (uint32_t)tail < PLACES),
         "refused or accepted against what it saw");
  seen.accepted += (uint32_t)taken;
  seen.refused += (uint32_t)!taken;
  if (taken) ring_set_watermark(&ring, (int64_t)seen.accepted + 1);
}

static void produce(void) {
  for (uint32_t i = 0; i < given.attempts; i++) push_one();
}

static void check_next(uint32_t i) {
  const struct item *item = ring_peek(&ring, i);
  touch(item, sizeof *item, READ);
  struct item whole;
  const uint32_t k = seen.taken + i + 1;
  memset(&whole, (int)k, sizeof whole);
  whole.real_ns = k;
  demand(memcmp(item, &whole, sizeof whole) == 0, "an item is not the next one, or not whole");
}

static void take(uint32_t n) {
  for (uint32_t i = 0; i < n; i++) check_next(i);
  ring_drop(&ring, n);
  seen.taken += n;
}

static void poll_once(void) {
  const int64_t mark = ring_watermark(&ring);
  const uint32_t n = ring_filled(&ring);
  demand(n <= PLACES && seen.taken + n <= seen.accepted, "more items than were pushed");
  demand(seen.taken + n + 1 >= (uint32_t)mark, "an item before the watermark is not there");
  if (n) take(n < given.at_once ? n : given.at_once);
}

static void consume(void) {
  for (uint32_t i = 0; i < given.polls; i++) poll_once();
}

static void run_thread(void) {
  running == PRODUCER ? produce() : consume();
  thread[running].over = 1;
}

/* ---- the search ---------------------------------------------------------------------- */

/* to its next atomic operation, or its end */
static void resume(int t) {
  running = t;
  swapcontext(&search, &thread[t].context);
  running = NOBODY;
}

static void start_thread(int t) {
  struct thread *it = &thread[t];
  memset(it, 0, sizeof *it);
  it->knows.step[t] = 1;
  getcontext(&it->context);
  it->context.uc_stack.ss_sp = stack[t];
  it->context.uc_stack.ss_size = STACK;
  it->context.uc_link = &search;
  makecontext(&it->context, run_thread, 0);
  resume(t);
}

static void start(void) {
  memset(cell, 0, sizeof cell);
  memset(message, 0, sizeof message);
  memset(&seen, 0, sizeof seen);
  if (ring_init(&ring, PLACES) != 0) exit(2);
  ring.head = ring.tail = given.first;
  message[HEAD][0].value = message[TAIL][0].value = given.first;
  for (int v = 0; v < VARIABLES; v++) messages[v] = 1;
  for (int t = 0; t < THREADS; t++) start_thread(t);
}

/* both threads have ended: what is left comes out, and nothing else */
static void check_end(void) {
  take(ring_filled(&ring));
  demand(seen.taken == seen.accepted, "an accepted item is lost");
  demand(seen.accepted + seen.refused == given.attempts, "an attempt is not counted");
  demand(ring_room(&ring) == PLACES, "an empty ring has not all its room");
  total.ends++;
  total.refusals += seen.refused != 0;
}

static int choices(struct choice choice[THREADS * MESSAGES]) {
  int n = 0;
  for (int t = 0; t < THREADS; t++) {
    const struct thread *it = &thread[t];
    if (it->over) continue;
    const int oldest = it->loads ? it->knows.message[it->variable] : 0;
    for (int m = oldest; m < (it->loads ? messages[it->variable] : 1); m++)
      choice[n++] = (struct choice){(uint8_t)t, (uint8_t)m};
  }
  return n;
}

static void step(struct choice choice) {
  thread[choice.thread].finds = choice.message;
  resume(choice.thread);
}

enum { TABLE = 1 << 19 };
static struct state *table;

/* is the present state new? Then it is kept. */
static int is_new(void) {
  struct state now;
  uint64_t hash = 1469598103934665603u; /* FNV-1a */
  memset(&now, 0, sizeof now);
  now.used = 1;
  for (int t = 0; t < THREADS; t++) {
    memcpy(now.log[t], thread[t].log, STEPS);
    now.steps[t] = thread[t].steps;
  }
  for (size_t i = 0; i < sizeof now; i++) hash = (hash ^ ((const uint8_t *)&now)[i]) * 1099511628211u;
  struct state *at = &table[hash % TABLE];
  while (at->used && memcmp(at, &now, sizeof now) != 0) at = at + 1 < table + TABLE ? at + 1 : table;
  if (at->used) return 0;
  *at = now;
  allow(++total.states < TABLE / 2, "states");
  return 1;
}

static struct choice trail[THREADS * STEPS];

static void replay(int depth) {
  ring_free(&ring);
  start();
  for (int i = 0; i < depth; i++) step(trail[i]);
}

/* everything that can follow the present state */
static void explore(int depth) {
  struct choice choice[THREADS * MESSAGES];
  if (!is_new()) return;
  const int n = choices(choice);
  if (n == 0) check_end();
  for (int i = 0; i < n; i++) {
    if (i) replay(depth);
    trail[depth] = choice[i];
    step(choice[i]);
    explore(depth + 1);
  }
}

int main(int argc, char **argv) {
  if (argc != 5) return 2;
  given.attempts = (uint32_t)strtoul(argv[1], NULL, 10);
  given.polls = (uint32_t)strtoul(argv[2], NULL, 10);
  given.at_once = (uint32_t)strtoul(argv[3], NULL, 10);
  given.first = (uint32_t)strtoul(argv[4], NULL, 10);
  table = calloc(TABLE, sizeof *table);
  if (!table) return 2;
  start();
  explore(0);
  ring_free(&ring);
  free(table);
  printf("states %lu, ends %lu, ends with refusals %lu, loads of old values %lu\n", total.states, total.ends,
         total.refusals, total.old_loads);
  return 0;
}
