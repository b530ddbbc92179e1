/* controller_sincos.h: sine and cosine in float for joint angles, inside lib/. */
#ifndef TALUS_CONTROLLER_SINCOS_H
#define TALUS_CONTROLLER_SINCOS_H

/* Of |x| <= 4 rad, absolute error <= 1.2e-7. x - k pi/2 with pi/2 in two parts, of which k times the first is exact;
 * polynomials of degree 7 and 8 by Chebyshev interpolation over +-pi/4. */
static inline void tl_sincos_float(float x, float *sine, float *cosine) {
  /* adding 1.5 * 2^23 rounds to a whole number */
  float k = (x * 0.636619772f + 12582912.0f) - 12582912.0f;
  float r = (x - k * 1.5703125f) - k * 4.83826795e-4f, z = r * r;
  float s = r + r * z * (-0.166666647f + z * (0.00833274827f - z * 0.000195878909f));
  float c = 1.0f - 0.5f * z + z * z * (0.0416666647f + z * (-0.0013888303f + z * 2.45479421e-5f));
  int turn = (int)k, odd = turn & 1;

  *sine = odd ? c : s;
  *cosine = odd ? s : c;
  *sine = turn & 2 ? -*sine : *sine;
  *cosine = (turn + 1) & 2 ? -*cosine : *cosine;
}

#endif
