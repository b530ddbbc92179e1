/* math.h: elementary functions with the same bits on every machine.
 *
 * Only + - * / and sqrt, fabs, floor are used, all of them exactly rounded by
 * IEEE 754 (rounding to nearest, as every program starts), and built with
 * -ffp-contract=off; so every result is the same on any conforming machine. The bounds below are tested against a
 * multi-precision reference. NaN in gives NaN out.
 *
 *     double s, c;
 *     tl_sincos(TL_PI / 6.0, &s, &c);
 *     printf("%.4f %.4f\n", s, c); // prints 0.5000 0.8660
 */
#ifndef TALUS_MATH_H
#define TALUS_MATH_H

#ifdef __cplusplus
extern "C" {
#endif

#define TL_PI 3.14159265358979323846

/* sin and cos of x [rad]; absolute error <= 1.9e-16 for |x| <= 1e9 rad, NaN
 * beyond and for infinities. Fastest for |x| <= 1e5. */
double tl_sin(double x);
double tl_cos(double x);
/* Both at once, same bits as tl_sin and tl_cos. Neither pointer may be NULL. */
void tl_sincos(double x, double *sin_x, double *cos_x);
/* tan x [rad], relative error <= 1e-15 for |x| <= 1e5 rad, near zeros and poles
 * too; NaN beyond 1e9. */
double tl_tan(double x);
/* Angle of the point (x, y) in (-pi, pi] [rad], relative error <= 5e-16;
 * signed zeros as in C99 Annex F; atan2(0, 0) = 0. */
double tl_atan2(double y, double x);
/* Inverse sine and cosine [rad], absolute error <= 5e-16; NaN for |x| > 1. */
double tl_asin(double x);
double tl_acos(double x);
/* e^x, relative error <= 3e-16 (half a unit of the last place more where the
 * result is subnormal); 0 below -745.2, +infinity above 709.79. */
double tl_exp(double x);
/* Natural logarithm, relative error <= 3e-16, near 1 too; -infinity at 0, NaN
 * below. */
double tl_log(double x);
/* x^y for x >= 0, relative error <= 1e-15 (1 + |y ln x|); NaN for x < 0
 * unless y is a whole number. pow(x, 0) = 1, whatever x. */
double tl_pow(double x, double y);
/* Hyperbolic tangent, relative error <= 1e-15. */
double tl_tanh(double x);

#ifdef __cplusplus
}
#endif
#endif
