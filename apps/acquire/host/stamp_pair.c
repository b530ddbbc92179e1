/* stamp_pair.c: a sequence count around the pair. Release on each store keeps the odd count before the stamps, and
 * acquire on each load keeps the second look at the count behind them. */
#include "stamp_pair.h"

void stamp_pair_publish(struct stamp_pair *pair, int64_t hardware_ns, int64_t real_ns) {
  const uint32_t sequence = __atomic_load_n(&pair->sequence, __ATOMIC_RELAXED);
  __atomic_store_n(&pair->sequence, sequence + 1, __ATOMIC_RELAXED);
  __atomic_store_n(&pair->hardware_ns, hardware_ns, __ATOMIC_RELEASE);
  __atomic_store_n(&pair->real_ns, real_ns, __ATOMIC_RELEASE);
  __atomic_store_n(&pair->sequence, sequence + 2, __ATOMIC_RELEASE);
}

int stamp_pair_read(const struct stamp_pair *pair, int64_t *hardware_ns, int64_t *real_ns) {
  uint32_t before, after;
  do {
    before = __atomic_load_n(&pair->sequence, __ATOMIC_ACQUIRE);
    *hardware_ns = __atomic_load_n(&pair->hardware_ns, __ATOMIC_ACQUIRE);
    *real_ns = __atomic_load_n(&pair->real_ns, __ATOMIC_ACQUIRE);
    after = __atomic_load_n(&pair->sequence, __ATOMIC_RELAXED);
  } while (before != after || before % 2);
  return before != 0;
}
