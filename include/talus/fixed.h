/* fixed.h: fixed-point numbers, for controllers without floating point.
 *
 * A number x in Qn is the whole number x 2^n in 32 bits, two's complement. What
 * leaves its range is held at the range's end and flagged, never wrapped. Each
 * routine is defined for every argument of its types, takes the same time for
 * all of them, and has its bound's argument beside it in lib/fixed*.
 *
 *     uint32_t saturated = 0;
 *     int32_t knee_q29 = tl_fixed_from_double(0.5, TL_Q_ANGLE, &saturated);
 *     int32_t gravity_q21 = tl_fixed_from_double(12.0, TL_Q_JOINT_TORQUE, &saturated);
 *     int32_t sine_q31, cosine_q31;
 *     tl_fixed_sincos(knee_q29, &sine_q31, &cosine_q31);
 *     int32_t torque_q21 = tl_fixed_multiply(gravity_q21, sine_q31, 31, &saturated);
 *     printf("%.4f\n", tl_fixed_to_double(torque_q21, TL_Q_JOINT_TORQUE)); // prints 5.7531
 *
 * Signed numbers are shifted right as every compiler for these machines does:
 * towards minus infinity (a test compares the images for Cortex-M).
 */
#ifndef TALUS_FIXED_H
#define TALUS_FIXED_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Fraction bits of what goes in and out of tl_controller_tick_q31. */
#define TL_Q_ANGLE 29        /* rad: +-4, 1.9e-9 apart */
#define TL_Q_SPEED 25        /* rad/s: +-64, 3.0e-8 apart */
#define TL_Q_ACCELERATION 19 /* rad/s^2: +-4096, 1.9e-6 apart */
#define TL_Q_JOINT_TORQUE 21 /* N m at the joint: +-1024, 4.8e-7 apart */
#define TL_Q_MOTOR_TORQUE 26 /* N m at the motor: +-32, 1.5e-8 apart */
#define TL_Q_CURRENT 20      /* A: +-2048, 9.5e-7 apart */

/* `wide` where it fits into 32 bits, else the nearer end, and *saturated = 1. */
int32_t tl_fixed_saturate(int64_t wide, uint32_t *saturated);
/* a b / 2^drop, rounded to nearest, halves up; drop 1..62. With a in Qm and b in Qn it is Q(m + n - drop). */
int32_t tl_fixed_multiply(int32_t a, int32_t b, int drop, uint32_t *saturated);

/* Sine and cosine in Q31 of an angle in Q29 rad, any of them. Absolute error <= 1.6e-9; 1 is given as
 * 1 - 2^-31. No pointer may be NULL. */
void tl_fixed_sincos(int32_t angle_q29, int32_t *sine_q31, int32_t *cosine_q31);

/* x in Qn, n 0..31, rounded to nearest; beyond the range its end, NaN 0, both with *saturated = 1. */
int32_t tl_fixed_from_double(double x, int n, uint32_t *saturated);
/* The number that q in Qn stands for, exactly. */
double tl_fixed_to_double(int32_t q, int n);

#ifdef __cplusplus
}
#endif
#endif
