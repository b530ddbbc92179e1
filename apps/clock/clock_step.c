/* clock_step.c: what changes faster than two clocks drift was set. */
#include "clock/clock_step.h"

#include <math.h>

static const double MOST_DRIFT = 600e-6; /* NTP slews by 500e-6, and quartzes differ */
static const double READ_NS = 20000.0;

double clock_most_drift(void) {
  return MOST_DRIFT;
}

double clock_read_ns(void) {
  return READ_NS;
}

double clock_drift_most_ns(double passed_ns, double widths_ns) {
  return MOST_DRIFT * fabs(passed_ns) + widths_ns + READ_NS;
}
