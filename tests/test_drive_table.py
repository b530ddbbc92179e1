"""A drive's tables: their error against the closed form, the bound that is said to be proven, and refusal."""

import numpy
import pytest
from leg_example import fixed, fourier, linkage
from talus import TalusError, check, ffi, lib

RANGE = numpy.pi / 6
NAMES = ("angle", "ratio", "inverse")


def make(transmission):
    knot, table = ffi.new("tl_curve_knot_f64[]", 3 * 129), ffi.new("tl_drive_table *")
    check(lib.tl_drive_table_make(table, transmission, knot))
    return table, knot


def in_fixed_point(table):
    """The three curves in Q31, with their knots."""
    curves, keep = [], []
    for name in NAMES:
        knot, c = ffi.new("tl_curve_knot_q31[]", 129), ffi.new("tl_curve_q31 *")
        check(lib.tl_curve_to_q31(ffi.addressof(table, name), 29, knot, c))
        curves.append(c)
        keep.append(knot)
    return curves, keep


def true_values(transmission, table, q):
    ratio, slope = ffi.new("double *"), ffi.new("double *")
    lib.tl_transmission_ratio(transmission, q, ratio, slope)
    motor = lib.tl_transmission_motor_angle(transmission, q)
    return motor / table.angle_scale_rad, ratio[0] / table.ratio_scale, 1 / ratio[0] / table.inverse_scale


def errors(transmission, table, counts):
    """Largest errors of the three at angles `counts` / 2^29, of full scale."""
    curves, _keep = in_fixed_point(table)
    slope, saturated, worst = ffi.new("int32_t *"), ffi.new("uint32_t *"), numpy.zeros(3)
    for count in counts:
        true = true_values(transmission, table, count / 2.0**29)
        got = [lib.tl_curve_at_q31(c, int(count), slope, saturated) / 2.0**31 for c in curves]
        worst = numpy.maximum(worst, numpy.abs(numpy.subtract(got, true)))
    assert not saturated[0]
    return worst


def bounds(table):
    return numpy.array([table.angle_error, table.ratio_error, table.inverse_error])


def test_default_linkage_over_its_range():
    """Every 2^-16 rad from -30 to 30 degrees; the tables for angle and ratio take at most 2 KB."""
    t = linkage()
    table, _keep = make(t)
    end = int(RANGE * 2**16)
    worst = errors(t, table, numpy.arange(-end, end + 1) * 2**13)
    assert (worst[:2] <= 4e-9).all()
    assert (worst <= bounds(table)).all() and (bounds(table)[:2] <= 4e-9).all()
    assert 2 * table.ratio.n * ffi.sizeof("tl_curve_knot_q31") <= 2048


def random_linkages(n, seed):
    rng = numpy.random.default_rng(seed)
    found = 0
    while found < n:
        lead, AB, BO, AC = rng.uniform(0.001, 0.01), rng.uniform(0.02, 0.3), rng.uniform(0.01, 0.1), rng.uniform(0, 0.08)
        t, dimensions = ffi.new("tl_transmission *"), ffi.new("tl_screw_linkage *", (lead, AB, BO, AC, rng.uniform(0, 360)))
        if lib.tl_transmission_screw_linkage(t, dimensions) == lib.TL_OK:
            found += 1
            yield t


def test_the_bound_holds_for_1000_random_linkages():
    """A linkage near a dead point may be too steep for Q31: it is refused, and never wrong."""
    rng, fine, refused = numpy.random.default_rng(7), 0, 0
    for t in random_linkages(1000, 11):
        try:
            table, _keep = make(t)
            in_fixed_point(table)
        except TalusError:
            refused += 1
            continue
        worst = errors(t, table, rng.integers(-int(RANGE * 2**29), int(RANGE * 2**29), 40))
        assert (worst <= bounds(table)).all()
        fine += bool((bounds(table)[:2] <= 4e-9).all())
    assert refused <= 150 and fine >= 800, (refused, fine)


def test_a_series_is_bounded_too():
    t = fourier(1.2, [0.3, -2.0, 0.4], [80.0, 3.0])
    table, _keep = make(t)
    assert (errors(t, table, range(-281104896, 281104896, 9973)) <= bounds(table)).all()


def test_what_has_no_table_is_refused():
    with pytest.raises(TalusError):
        make(fixed(51.0))
    with pytest.raises(TalusError):  # its ratio changes sign
        linkage((0.002, 0.09, 0.04, 0.035, 180.0))
    reversing = ffi.new("tl_transmission *", fourier(1.0, [0.0], [5.0])[0])
    reversing.fourier.b[0], reversing.fourier.a[2] = 1.0, 8.0
    with pytest.raises(TalusError):
        make(reversing)
