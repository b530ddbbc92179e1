"""Tables with cubic Hermite interpolation: against the polynomial they must hold exactly, and at their ends."""

import numpy
import pytest
from numpy.polynomial import Polynomial
from scipy.interpolate import CubicHermiteSpline
from talus import TalusError, check, ffi, lib


def curve(value, slope, first, step):
    """The curve in double with its knots."""
    knot = ffi.new("tl_curve_knot_f64[]", [(v, s * step) for v, s in zip(value, slope, strict=True)])
    c = ffi.new("tl_curve_f64 *")
    check(lib.tl_curve_init_f64(c, knot, len(value), first, step))
    return c, knot


def wave(n=65, first=-1.0, step=1 / 32):
    x = first + step * numpy.arange(n)
    return curve(0.9 * numpy.sin(x), 0.9 * numpy.cos(x), first, step), x


def at_f64(c, x):
    slope = ffi.new("double *")
    return numpy.array([(lib.tl_curve_at_f64(c, v, slope), slope[0]) for v in x]).T


def test_is_the_hermite_spline_of_scipy():
    (c, _keep), knots = wave()
    x = numpy.random.default_rng(1).uniform(-1, 1, 2000)
    spline = CubicHermiteSpline(knots, 0.9 * numpy.sin(knots), 0.9 * numpy.cos(knots))
    value, slope = at_f64(c, x)
    assert numpy.abs(value - spline(x)).max() <= 1e-15
    assert numpy.abs(slope * 32 - spline(x, 1)).max() <= 1e-13


def test_holds_a_cubic_exactly_and_its_ends_beyond():
    p = Polynomial([0.1, -0.2, 0.05, 0.03])
    knots = numpy.linspace(-2, 2, 5)
    c, _keep = curve(p(knots), p.deriv()(knots), -2.0, 1.0)
    x = numpy.linspace(-2, 2, 301)
    assert numpy.abs(at_f64(c, x)[0] - p(x)).max() <= 1e-15
    assert at_f64(c, [-3.0, 5.0, 1e300, -numpy.inf])[0] == pytest.approx([p(-2), p(2), p(2), p(-2)], abs=1e-15)


def test_float_and_fixed_point_are_the_same_curve():
    (c, _keep), _ = wave()
    f, q = ffi.new("tl_curve_f32 *"), ffi.new("tl_curve_q31 *")
    knot_f32, knot_q31 = ffi.new("tl_curve_knot_f32[65]"), ffi.new("tl_curve_knot_q31[65]")
    lib.tl_curve_to_f32(c, knot_f32, f)
    check(lib.tl_curve_to_q31(c, 29, knot_q31, q))
    whole = [-(2**31), 2**31 - 1, *map(int, numpy.random.default_rng(2).integers(-(2**29), 2**29 + 1, 20000))]
    x = numpy.array(whole) / 2.0**29
    value, slope = at_f64(c, x)
    slope_f32, slope_q31, saturated = ffi.new("float *"), ffi.new("int32_t *"), ffi.new("uint32_t *")
    got = numpy.array([(lib.tl_curve_at_f32(f, v, slope_f32), slope_f32[0]) for v in x]).T
    assert numpy.abs(got[0] - value).max() <= 2e-7
    assert numpy.abs(got[1] - slope).max() <= 2e-7
    got = numpy.array([(lib.tl_curve_at_q31(q, v, slope_q31, saturated), slope_q31[0]) for v in whole]).T
    assert numpy.abs(got[0] / 2**31 - value).max() <= 2.2 / 2**31 + 1.5 / 32 * 2.0**-25
    assert numpy.abs(got[1] / 2**31 - slope).max() <= 6 / 2**31 + 1.5 / 32 * 2.0**-25
    assert not saturated[0]


def test_a_wild_table_in_fixed_point_is_held_and_flagged():
    """Any table, any argument: the result is within Q31, and what would have wrapped is flagged."""
    rng = numpy.random.default_rng(5)
    slope, flags = ffi.new("int32_t *"), 0
    for _ in range(2000):
        knot = ffi.new("tl_curve_knot_q31[33]", [tuple(map(int, rng.integers(-(2**31), 2**31, 2))) for _ in range(33)])
        words = [int(v) for v in rng.integers(0, 2**32, 2)]
        c = ffi.new("tl_curve_q31 *", (knot, 33, int(rng.integers(-(2**31), 2**31)), words[0], int(rng.integers(0, 32)), words[1]))
        saturated = ffi.new("uint32_t *")
        assert -(2**31) <= lib.tl_curve_at_q31(c, int(rng.integers(-(2**31), 2**31)), slope, saturated) < 2**31
        flags += saturated[0]
    assert flags > 100


@pytest.mark.parametrize(("end", "slope"), [(2**31 - 1, 2**27), (-(2**31), -(2**27))])
def test_a_table_that_swings_beyond_the_range_is_held_and_flagged(end, slope):
    """Knots at the range's end whose slopes are no steeper than a table's may be."""
    knot = ffi.new("tl_curve_knot_q31[2]", [(end, slope), (end, slope)])
    c = ffi.new("tl_curve_q31 *", (knot, 2, 0, 2**31, 0, 2**25))  # one step over 0 to 2^31
    saturated, slope_out = ffi.new("uint32_t *"), ffi.new("int32_t *")
    assert lib.tl_curve_at_q31(c, 2**29, slope_out, saturated) == end and saturated[0] == 1
    saturated[0] = 0
    assert lib.tl_curve_at_q31(c, 0, slope_out, saturated) == end and saturated[0] == 0


@pytest.mark.parametrize(("n", "first", "step"), [(1, 0.0, 1.0), (130, 0.0, 1.0), (4, 0.0, 0.0), (4, float("nan"), 1.0)])
def test_what_is_no_table_is_refused(n, first, step):
    knot, c = ffi.new("tl_curve_knot_f64[130]"), ffi.new("tl_curve_f64 *")
    with pytest.raises(TalusError):
        check(lib.tl_curve_init_f64(c, knot, n, first, step))


@pytest.mark.parametrize("knots", [[(1.1, 0), (1, 0)], [(0, 0.09), (0, 0)], [(0, 0), (0.09, 0)]])
def test_what_does_not_fit_fixed_point_is_refused(knots):
    knot, q = ffi.new("tl_curve_knot_f64[]", knots), ffi.new("tl_curve_q31 *")
    c = ffi.new("tl_curve_f64 *")
    check(lib.tl_curve_init_f64(c, knot, 2, 0.0, 0.01))
    with pytest.raises(TalusError):
        check(lib.tl_curve_to_q31(c, 29, ffi.new("tl_curve_knot_q31[2]"), q))
