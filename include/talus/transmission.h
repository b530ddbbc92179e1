/* transmission.h: motor angle against joint angle.
 *
 * One interface over a fixed ratio, the screw linkage in closed form, its
 * Fourier series (10, 11) of the source paper and a lookup table, so that the
 * dynamics take any of them.
 *
 *     tl_transmission ankle;
 *     tl_screw_linkage link = {0.002, 0.090, 0.040, 0.035, 84.75};
 *     if (tl_transmission_screw_linkage(&ankle, &link) != TL_OK) return 1;
 *     double ratio, slope;
 *     tl_transmission_ratio(&ankle, 0.2, &ratio, &slope);
 *     double motor_rad = tl_transmission_motor_angle(&ankle, 0.2);
 *     printf("%.3f\n", tl_transmission_joint_angle(&ankle, motor_rad)); // prints 0.200
 */
#ifndef TALUS_TRANSMISSION_H
#define TALUS_TRANSMISSION_H

#include <stddef.h>

#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum tl_transmission_kind {
  TL_TRANSMISSION_FIXED = 0,
  TL_TRANSMISSION_SCREW_LINKAGE = 1,
  TL_TRANSMISSION_FOURIER = 2,
  TL_TRANSMISSION_TABLE = 3
} tl_transmission_kind;

#define TL_FOURIER_ORDER 8                    /* harmonics of (10) */
#define TL_JOINT_RANGE_RAD 0.5235987755982988 /* pi/6: the range of (10) and of every table */

/* The screw linkage's dimensions, as in the model file. */
typedef struct tl_screw_linkage {
  double lead_m;  /* screw lead p, > 0 */
  double AB_m;    /* coupler, > 0 */
  double BO_m;    /* crank, > 0 */
  double AC_m;    /* offset of the nut's joint from the screw's axis, >= 0 */
  double BOF_deg; /* fixed angle between crank and foot */
} tl_screw_linkage;

/* Motor angle as a Fourier series of the joint angle, (10):
 * motor = a[0] + sum over j = 1..8 of a[j] cos(j omega q) + b[j-1] sin(j omega q). */
typedef struct tl_fourier {
  double omega; /* [1/rad], > 0 */
  double a[TL_FOURIER_ORDER + 1];
  double b[TL_FOURIER_ORDER];
} tl_fourier;

/* One knot of a table: motor angle, its slope and the slope's slope. */
typedef struct tl_table_knot {
  double motor_rad;
  double ratio;       /* d motor / d joint */
  double ratio_slope; /* d ratio / d joint [1/rad] */
} tl_table_knot;

/* Evenly spaced knots over [first_rad, first_rad + (n-1) step_rad]. Between
 * them the motor angle is the cubic Hermite of (motor, ratio) and the ratio that
 * of (ratio, ratio_slope); slope is the derivative of the latter. So motor and
 * ratio are continuous with their slopes, slope is exactly d ratio / d joint, and
 * ratio is d motor / d joint to O(step^3). Errors: step^4 / 384 times the largest
 * fourth derivative. `knot` is the caller's and must outlive the table. */
typedef struct tl_table {
  const tl_table_knot *knot; /* (n) */
  size_t n;                  /* >= 2 */
  double first_rad;
  double step_rad; /* > 0 */
} tl_table;

/* Plain data; initialise it with one of the calls below. Copying is fine. */
typedef struct tl_transmission {
  tl_transmission_kind kind;
  double ratio; /* fixed */
  tl_screw_linkage linkage;
  /* precomputed from `linkage`: */
  double phi0_rad; /* crank angle at joint angle 0: pi - BOF */
  double cos_phi0, sin_phi0;
  double screw_rad_m; /* 2 pi / lead */
  double nut0_m;      /* CO at joint angle 0 */
  double elbow;       /* +1 or -1: on which side of OA the crank stands (the ratio's sign) */
  tl_fourier fourier;
  tl_table table;
} tl_transmission;

/* Outside its range (series: +-30 degrees, table: its knots) an approximation
 * goes on with the ratio of its edge: motor straight, ratio constant, slope 0.
 * The linkage is exact wherever it closes and NaN where it does not. For the rest
 * NaN in gives NaN out, but for a fixed ratio's. */

/* motor = ratio * joint; ratio finite and not 0, else TL_ERR_RANGE. */
TL_CHECK tl_status tl_transmission_fixed(tl_transmission *t, double ratio);
/* The closed form. TL_ERR_RANGE when a dimension is not positive or the
 * linkage does not close over +-30 degrees, AB^2 > (AC - BO sin phi)^2, or has a
 * dead point (ratio 0) there; both are decided exactly, not by sampling. */
TL_CHECK tl_status tl_transmission_screw_linkage(tl_transmission *t, const tl_screw_linkage *linkage);
/* The series; TL_ERR_RANGE when not finite or the ratio changes sign in range
 * (looked at in 257 points). */
TL_CHECK tl_status tl_transmission_fourier(tl_transmission *t, const tl_fourier *fourier);
/* A lookup table over knots that the caller filled, see tl_transmission_tabulate.
 * TL_ERR_RANGE when a number is not finite, or the motor angle is not certain to
 * be monotone (Fritsch and Carlson 1980) or the ratio not certain to keep its sign. */
TL_CHECK tl_status tl_transmission_table(tl_transmission *t, const tl_table_knot *knot, size_t n,
                                         double first_rad, double step_rad);

/* Motor angle [rad] at joint angle q [rad]. */
double tl_transmission_motor_angle(const tl_transmission *t, double joint_rad);
/* Joint angle [rad] at a motor angle [rad]: the inverse, exact for fixed ratio
 * and linkage (closed form; NaN where the nut is out of reach), by safeguarded
 * Newton steps (usually 4, at most 64) for series and table. */
double tl_transmission_joint_angle(const tl_transmission *t, double motor_rad);
/* ratio = d motor / d joint, slope = d ratio / d joint [1/rad]. No pointer may be NULL. */
void tl_transmission_ratio(const tl_transmission *t, double joint_rad, double *ratio, double *slope);
/* The same where sin q and cos q are at hand already (saves their cost). */
void tl_transmission_ratio_sc(const tl_transmission *t, double joint_rad, double sin_q, double cos_q,
                              double *ratio, double *slope);
/* The same for n angles. */
void tl_transmission_motor_angles(const tl_transmission *t, const double *joint_rad, size_t n,
                                  double *motor_rad);
void tl_transmission_joint_angles(const tl_transmission *t, const double *motor_rad, size_t n,
                                  double *joint_rad);
void tl_transmission_ratios(const tl_transmission *t, const double *joint_rad, size_t n, double *ratio);
/* Joint motion from motor motion: q, q', q'' from motor angle, speed and acceleration. */
void tl_transmission_joint_motion(const tl_transmission *t, const double motor[3], double joint[3]);

/* Fill n knots over [first_rad, last_rad] from any transmission; n >= 2. */
TL_CHECK tl_status tl_transmission_tabulate(const tl_transmission *t, double first_rad, double last_rad,
                                            tl_table_knot *knot, size_t n);

/* Least-squares Fourier series (10) of `harmonics` <= 8 terms to n samples of t's motor
 * angle, evenly over +-range_rad, at the base frequency omega that fits best
 * (a scan of 17 in [omega_low, omega_high], golden section around its best). The rest of
 * the coefficients is 0. TL_ERR_TOO_SHORT when n < 2 harmonics + 1.
 * `work` holds tl_fourier_fit_workspace(n, harmonics) doubles. */
size_t tl_fourier_fit_workspace(size_t n, int harmonics);
TL_CHECK tl_status tl_fourier_fit(const tl_transmission *t, double range_rad, size_t n, int harmonics,
                                  double omega_low, double omega_high, double *work, size_t work_n,
                                  tl_fourier *out);

/* Largest differences of `approx` from `reference` over +-range_rad at n
 * points: motor angle [rad] and ratio (relative to the reference's ratio). */
void tl_transmission_error(const tl_transmission *approx, const tl_transmission *reference, double range_rad,
                           size_t n, double *motor_rad, double *ratio_relative);

#ifdef __cplusplus
}
#endif
#endif
