/* transmission_internal.h: what the kinds of transmission share inside lib/. */
#ifndef TALUS_TRANSMISSION_INTERNAL_H
#define TALUS_TRANSMISSION_INTERNAL_H

#include <math.h>

#include "math_inline.h"
#include "talus/transmission.h"

/* The linkage's ratio and slope from sin q and cos q. With O at the origin and
 * the screw along x: B = (x, y) on the crank at phi = phi0 - q, h what A stands
 * above B, root the nut's lead over B. x' = y, y' = -x, h' = x, root' = -h x / root,
 * so with w = h x / root
 *     CO  = x + root,   CO' = y - w,   CO'' = -x - (x^2 + h y + w^2) / root. */
static inline void tl_linkage_ratio(const tl_transmission *t, double sin_q, double cos_q, double *ratio,
                                    double *slope) {
  double x = t->linkage.BO_m * (t->cos_phi0 * cos_q + t->sin_phi0 * sin_q);
  double y = t->linkage.BO_m * (t->sin_phi0 * cos_q - t->cos_phi0 * sin_q);
  double h = t->linkage.AC_m - y;
  double per_root = 1.0 / sqrt(t->linkage.AB_m * t->linkage.AB_m - h * h);
  double w = h * x * per_root;

  *ratio = t->screw_rad_m * (y - w);
  *slope = -t->screw_rad_m * (x + (x * x + h * y + w * w) * per_root);
}

/* joint angle at a motor angle, closed form; motor angle at sin q, cos q */
double tl_linkage_joint_angle(const tl_transmission *t, double motor_rad);
double tl_linkage_motor_angle(const tl_transmission *t, double sin_q, double cos_q);

/* value, slope and curvature of the series, inside its range or beyond it */
typedef struct tl_curve {
  double motor, ratio, slope;
} tl_curve;

tl_curve tl_fourier_curve(const tl_fourier *f, double joint_rad);
double tl_table_motor_angle(const tl_table *t, double joint_rad);
void tl_table_ratio(const tl_table *t, double joint_rad, double *ratio, double *slope);

#endif
