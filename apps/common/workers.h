/* workers.h: the same work on several processors.
 *
 *     void *worker[WORKERS_MOST];
 *     int n = workers_processors(), ready = 0;
 *     while (ready < n && (worker[ready] = new_worker())) ready++;
 *     workers_run(work, worker, ready);
 *
 * What the work is, and in which order it is put together, is the caller's: the same result for any number.
 */
#ifndef WORKERS_H
#define WORKERS_H

#define WORKERS_MOST 4

/* Processors to work on, 1..WORKERS_MOST. */
int workers_processors(void);

/* Runs work(worker[i]) for all i, the first on this thread and each other one on its own, and waits for all. Where a
 * thread cannot be started its worker and those behind it do nothing, so the first must be able to do all that there
 * is. 1 <= n <= WORKERS_MOST. */
void workers_run(void (*work)(void *worker), void *const *worker, int n);

#endif
