/* transmission_linkage.c: the screw linkage in closed form, docs/equations.md.
 *
 * O is the ankle, the screw's axis runs along x, the nut stands at C = (CO, 0)
 * and carries the coupler's joint A = (CO, AC); B = BO (cos phi, sin phi) is the
 * crank's end, phi = pi - BOF - q by (4), and |AB| is fixed.
 */
#include <math.h>

#include "talus/math.h"
#include "talus/transmission.h"
#include "transmission_internal.h"

#define COS_RANGE 0.86602540378443864676 /* cos TL_JOINT_RANGE_RAD */
#define SIN_RANGE 0.5

double tl_linkage_motor_angle(const tl_transmission *t, double sin_q, double cos_q) {
  double x = t->linkage.BO_m * (t->cos_phi0 * cos_q + t->sin_phi0 * sin_q);
  double y = t->linkage.BO_m * (t->sin_phi0 * cos_q - t->cos_phi0 * sin_q);
  double h = t->linkage.AC_m - y;

  return t->screw_rad_m * (x + sqrt(t->linkage.AB_m * t->linkage.AB_m - h * h) - t->nut0_m);
}

double tl_linkage_joint_angle(const tl_transmission *t, double motor_rad) {
  double CO = t->nut0_m + motor_rad / t->screw_rad_m, AC = t->linkage.AC_m;
  double BO = t->linkage.BO_m, AB = t->linkage.AB_m;
  double AO2 = CO * CO + AC * AC;
  /* law of cosines at O: along = 2 BO AO cos(BOA), across = 2 BO AO sin(BOA) */
  double along = AO2 + (BO - AB) * (BO + AB);
  double across = t->elbow * sqrt(4.0 * (BO * BO) * AO2 - along * along);
  /* B's direction (not normed): OA turned by the angle BOA */
  double cos_phi = along * CO - across * AC, sin_phi = along * AC + across * CO;

  return tl_atan2(t->sin_phi0 * cos_phi - t->cos_phi0 * sin_phi,
                  t->cos_phi0 * cos_phi + t->sin_phi0 * sin_phi);
}

/* is the crank angle with this sine and cosine within the joint's range */
static int in_range(const tl_transmission *t, double sin_phi, double cos_phi) {
  return cos_phi * t->cos_phi0 + sin_phi * t->sin_phi0 >= COS_RANGE;
}

/* AB^2 > (AC - y)^2 over the range: y is largest and smallest at its ends or at phi = +-pi/2 */
static int closes(const tl_transmission *t) {
  double reach = t->linkage.AB_m, BO = t->linkage.BO_m, AC = t->linkage.AC_m;
  double middle = t->sin_phi0 * COS_RANGE, swing = fabs(t->cos_phi0 * SIN_RANGE);
  double high = in_range(t, 1.0, 0.0) ? 1.0 : middle + swing;
  double low = in_range(t, -1.0, 0.0) ? -1.0 : middle - swing;

  return fabs(AC - BO * high) < reach && fabs(AC - BO * low) < reach;
}

/* The ratio vanishes where O, B and A lie on one line, OA = BO + AB or BO - AB
 * along the crank: there OA sin phi = AC, and A stands to the right of B. */
static int has_dead_point(const tl_transmission *t) {
  int i;

  /* AB = BO with AC = 0: the nut comes to rest on O itself */
  if (t->linkage.AC_m == 0.0 && t->linkage.AB_m == t->linkage.BO_m) return 1;
  for (i = 0; i < 2; i++) {
    double side = i ? -1.0 : 1.0;
    double sin_phi = t->linkage.AC_m / (t->linkage.BO_m + side * t->linkage.AB_m);

    /* for BO = AB the second sine is infinite: no such point */
    if (fabs(sin_phi) <= 1.0 && in_range(t, sin_phi, side * sqrt(1.0 - sin_phi * sin_phi))) return 1;
  }
  return 0;
}

static int dimensions_are_physical(const tl_screw_linkage *l) {
  return l->lead_m > 0.0 && l->AB_m > 0.0 && l->BO_m > 0.0 && l->AC_m >= 0.0 && tl_is_finite(l->lead_m) &&
         tl_is_finite(l->AB_m) && tl_is_finite(l->BO_m) && tl_is_finite(l->AC_m) && fabs(l->BOF_deg) <= 360.0;
}

tl_status tl_transmission_screw_linkage(tl_transmission *t, const tl_screw_linkage *linkage) {
  tl_transmission made = {.kind = TL_TRANSMISSION_SCREW_LINKAGE};
  double ratio, slope;

  if (!t || !linkage) return TL_ERR_ARGUMENT;
  if (!dimensions_are_physical(linkage)) return TL_ERR_RANGE;
  made.linkage = *linkage;
  made.phi0_rad = TL_PI * (1.0 - linkage->BOF_deg / 180.0);
  tl_sincos(made.phi0_rad, &made.sin_phi0, &made.cos_phi0);
  if (!closes(&made) || has_dead_point(&made)) return TL_ERR_RANGE;

  /* CO at joint angle 0, by the very sum that motor_angle makes */
  made.screw_rad_m = 1.0;
  made.nut0_m = tl_linkage_motor_angle(&made, 0.0, 1.0);
  made.screw_rad_m = 2.0 * TL_PI / linkage->lead_m;
  tl_linkage_ratio(&made, 0.0, 1.0, &ratio, &slope);
  made.elbow = ratio > 0.0 ? 1.0 : -1.0;
  *t = made;
  return TL_OK;
}
