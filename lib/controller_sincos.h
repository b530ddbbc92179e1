/* controller_sincos.h: sine and cosine in float for joint angles, inside lib/. */
#ifndef TALUS_CONTROLLER_SINCOS_H
#define TALUS_CONTROLLER_SINCOS_H

/* Of |x| <= 4 rad, absolute error <= 1.1e-6, and <= 4.5e-7 within 2 rad. From the half angle h without a quadrant: sin x =
 * 2 sin h cos h, cos x = 1 - 2 sin^2 h; polynomials of degree 9 and 10 by Chebyshev interpolation over |h| <= 2. */
static inline void tl_sincos_float(float x, float *sine, float *cosine) {
  float h = 0.5f * x, z = h * h;
  float s = h * (0.999999953f +
                 z * (-0.166666079f + z * (0.00833215476f + z * (-1.97582701e-4f + z * 2.51538628e-6f))));
  float c = 0.999999996f +
            z * (-0.49999993f +
                 z * (0.0416664611f + z * (-0.00138866887f + z * (2.46948312e-5f + z * -2.51527899e-7f))));
  float twice = s + s;

  *sine = twice * c;
  *cosine = 1.0f - twice * s;
}

#endif
