/* curve_template.h: a cubic between two knots, written once for every scalar (fixed_scalar_*.h, included before).
 *
 * With the step as unit of length, rise = y1 - y0 and slopes d0, d1 at its ends, the cubic is
 *     y0 + u (d0 + u (c2 + u c3)),   c3 = d0 + d1 - 2 rise,   c2 = rise - d0 - c3.
 *
 * Bounds in fixed point, of a curve that tl_curve_to_q31 has let through (|d|, |rise| <= B = 1/12 of 2^31): |c3| <= 4 B;
 * c2 + u c3 goes evenly from 3 rise - 2 d0 - d1 to rise - d0: <= 6 B < 2^30; the next bracket is a mean slope from the left knot,
 * and no slope of the cubic is beyond 2 B. So only the last sum, near an end of [-1, 1], can reach the range's end: it is
 * held there. Any other curve is flagged and not followed (CURVE_CHECK).
 * Rounding: each product errs by at most half of 2^-31, those inside are shrunk by u again, knots err by half: the
 * value is within 1/2 (knot) + 3 * 1/2 + 4/27 * 2 * 1/2 = 2.2 units of 2^-31.
 */
static inline REAL NAMED(curve_cubic)(const NAMED(tl_curve_knot) * k, REAL u, REAL *slope,
                                      uint32_t *saturated) {
  REAL rise = LESS(k[1].value, k[0].value), d0 = k[0].rise, d1 = k[1].rise, c3, inner, outer;

  (void)saturated;
  CURVE_CHECK(d0, d1, rise);
  c3 = LESS(ADD(d0, d1), ADD(rise, rise));
  inner = ADD_PART(LESS(LESS(rise, d0), c3), u, c3);
  outer = ADD_PART(d0, u, inner);
  /* d0 + u (2 c2 + 3 u c3) = outer + u (inner + u c3), whose bracket goes evenly from c2 to d1 - rise */
  *slope = ADD_PART(outer, u, ADD_PART(inner, u, c3));
  return SAT((WIDE)k[0].value + ADD_PART(0, u, outer));
}

static inline REAL NAMED(curve_at)(const NAMED(tl_curve) * c, REAL x, REAL *slope, uint32_t *saturated) {
  int32_t i;
  REAL u;

  TL_CURVE_LOCATE(c, x, i, u);
  return NAMED(curve_cubic)(c->knot + i, u, slope, saturated);
}
