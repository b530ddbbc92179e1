/* peak.c: runs a program and says what it took, for tools/bench/growth.py.
 *
 *   peak PROGRAM ARGUMENT...
 *
 * Prints JSON as the last line of standard output: exit status, seconds on the clock
 * and on the processors, largest resident memory. A small program of its own, because
 * the figure for memory begins with what the parent held when it made the child.
 */
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static double seconds_of(struct timeval t) {
  return (double)t.tv_sec + 1e-6 * (double)t.tv_usec;
}

static double now_s(void) {
  struct timespec now = {0, 0};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int main(int argc, char **argv) {
  if (argc < 2) return 2;
  const double begin_s = now_s();
  const pid_t child = fork();
  if (child == 0) {
    execv(argv[1], argv + 1);
    _exit(127);
  }
  int status = 0;
  struct rusage used;
  if (child < 0 || waitpid(child, &status, 0) != child || getrusage(RUSAGE_CHILDREN, &used) != 0) {
    perror("peak");
    return 1;
  }
  printf("{\"status\": %d, \"wall_s\": %.6f, \"cpu_s\": %.6f, \"peak_kB\": %ld}\n",
         WIFEXITED(status) ? WEXITSTATUS(status) : -1, now_s() - begin_s,
         seconds_of(used.ru_utime) + seconds_of(used.ru_stime), used.ru_maxrss);
  return 0;
}
