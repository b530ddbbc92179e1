/* export_report.h: what talus-acquire-export says of a recording's clock.
 *
 *     double near_s;
 *     if (export_report_offset("walk.json", &near_s, &error) != 0) ... // the recording's time less CLOCK_MONOTONIC
 */
#ifndef EXPORT_REPORT_H
#define EXPORT_REPORT_H

#include "common/error.h"

/* 0, or -1: it is no such report, or the recording stands on another clock. */
int export_report_offset(const char *path, double *offset_s, struct app_error *error);

#endif
