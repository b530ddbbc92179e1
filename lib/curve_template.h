/* curve_template.h: a cubic between two knots, written once for every scalar (fixed_scalar_*.h, included before).
 *
 * With the step as unit of length, rise = y1 - y0 and slopes d0, d1 at its ends, the cubic is
 *     y0 + u (d0 + u (c2 + u c3)),   c3 = d0 + d1 - 2 rise,   c2 = rise - d0 - c3.
 *
 * Bounds in fixed point, of a curve that tl_curve_to_q31 has let through (|d|, |rise| <= 1/12 of 2^31): |c3| <= 4/12,
 * |c2| <= 6/12, u <= 1, so the brackets stay within 11/12, and only the last sum, near an end of [-1, 1], can
 * reach the range's end: it is held there. Of any other curve every sum is held.
 * Rounding: each product errs by at most half of 2^-31, those inside are shrunk by u again, knots err by half: the
 * value is within 1/2 (knot) + 3 * 1/2 + 4/27 * 2 * 1/2 = 2.2 units of 2^-31.
 */
static inline REAL NAMED(curve_cubic)(const NAMED(tl_curve_knot) * k, REAL u, REAL *slope,
                                      uint32_t *saturated) {
  REAL rise = SAT((WIDE)k[1].value - k[0].value), d0 = k[0].rise;
  REAL c3 = SAT((WIDE)d0 + k[1].rise - (WIDE)2 * rise), c2 = SAT((WIDE)rise - d0 - c3);
  REAL inner = SAT(c2 + MUL(u, c3, 30)), outer = SAT(d0 + MUL(u, inner, 30));

  (void)saturated;
  /* d0 + u (2 c2 + 3 u c3) = outer + u (inner + u c3) */
  *slope = SAT(outer + MUL(u, SAT(inner + MUL(u, c3, 30)), 30));
  return SAT(k[0].value + MUL(u, outer, 30));
}

static inline REAL NAMED(curve_at)(const NAMED(tl_curve) * c, REAL x, REAL *slope, uint32_t *saturated) {
  int32_t i;
  REAL u;

  TL_CURVE_LOCATE(c, x, i, u);
  return NAMED(curve_cubic)(c->knot + i, u, slope, saturated);
}
