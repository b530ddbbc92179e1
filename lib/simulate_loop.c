/* simulate_loop.c: what a drive's position loop sees of its encoder; see talus/experimental/simulate.h. */
#include <math.h>

#include "talus/experimental/simulate.h"

double tl_loop_grid(double x, double step) {
  return step > 0.0 ? floor(x / step + 0.5) * step : x;
}

double tl_loop_speed(double seen, double tick_hz, double share, double *position, double *speed) {
  *speed += share * ((seen - *position) * tick_hz - *speed);
  *position = seen;
  return *speed;
}
