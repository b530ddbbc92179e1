"""talus/transmission.h against the loop closure solved with many digits, and theory's error bounds."""

import math
import random

import numpy as np
import pytest
from leg_example import EXAMPLE_LINKAGE, fixed, fourier, linkage, table
from mpmath import mp, mpf
from talus import TalusError, check, constants, ffi, lib

RANGE = constants.TL_JOINT_RANGE_RAD
EPS = 2.0**-52
ANGLES = np.linspace(-RANGE, RANGE, 1001)
LINKAGES = [
    EXAMPLE_LINKAGE,
    (0.005, 0.120, 0.050, 0.020, 60.0),
    (0.002, 0.090, 0.040, 0.0, 95.0),
    (0.003, 0.070, 0.045, 0.020, -120.0),  # crank on the other side: a negative ratio
    (0.003, 0.070, 0.080, 0.030, 90.0),  # crank longer than coupler
]


def motor_angle(t, q):
    return lib.tl_transmission_motor_angle(t, q)


def joint_angle(t, motor):
    return lib.tl_transmission_joint_angle(t, motor)


def ratio(t, q):
    """(ratio, slope)"""
    out = ffi.new("double[2]")
    lib.tl_transmission_ratio(t, q, out, out + 1)
    return out[0], out[1]


def refusal(call, *arguments):
    """The status of a call, which must leave its output alone."""
    t = ffi.new("tl_transmission *")
    t.ratio = 1234.5
    status = call(t, *arguments)
    assert (t.ratio == 1234.5) == (status != lib.TL_OK)
    return status


# ---- the linkage --------------------------------------------------------------


def nut_by_closure(dimensions, q):
    """CO where |AB| is what it must be, found by Newton's method in the current precision."""
    _, AB, BO, AC, BOF = (mpf(x) for x in dimensions)
    phi = mp.pi - BOF * mp.pi / 180 - q
    bx, by = BO * mp.cos(phi), BO * mp.sin(phi)
    return mp.findroot(lambda co: (co - bx) ** 2 + (AC - by) ** 2 - AB**2, bx + AB)


def motor_by_closure(dimensions, q):
    travel = nut_by_closure(dimensions, q) - nut_by_closure(dimensions, mpf(0))
    return 2 * mp.pi / mpf(dimensions[0]) * travel


def derivatives_by_closure(dimensions, q):
    """Motor angle, ratio and slope, by differences of the closure; wants 60 digits."""
    return [mp.diff(lambda x: motor_by_closure(dimensions, x), mpf(q), k, h=mpf(10) ** -15) for k in range(3)]


@pytest.mark.parametrize("dimensions", LINKAGES)
def test_linkage_is_the_loop_closure(dimensions):
    """Motor angle, ratio and slope against the closure and its numerical derivatives (60 digits)."""
    t = linkage(dimensions)
    screw = 2 * math.pi / dimensions[0]
    size = screw * max(dimensions[1:4])  # what the sums in the closed form are made of
    with mp.workdps(60):
        for q in (-RANGE, -0.31, -1e-9, 0.0, 0.123456789, 0.4, RANGE):
            exact = derivatives_by_closure(dimensions, q)
            got = (motor_angle(t, q), *ratio(t, q))
            # rounding: some twenty operations, each half an ulp of a term; a short root enlarges it
            root = float(nut_by_closure(dimensions, mpf(q))) - dimensions[2] * math.cos(t.phi0_rad - q)
            for k in range(3):
                assert abs(got[k] - exact[k]) <= 16 * EPS * size * (dimensions[1] / root) ** (2 * k)
    assert motor_angle(t, 0.0) == 0.0


def test_example_linkage_ratio_has_full_precision():
    t = linkage()
    with mp.workdps(60):
        for q in np.linspace(-RANGE, RANGE, 61):
            assert abs(ratio(t, q)[0] / derivatives_by_closure(EXAMPLE_LINKAGE, q)[1] - 1) <= 10 * EPS


@pytest.mark.parametrize("dimensions", LINKAGES)
def test_linkage_round_trip(dimensions):
    t = linkage(dimensions)
    for q in ANGLES:
        motor = motor_angle(t, q)
        assert abs(joint_angle(t, motor) - q) <= 1e-12
        assert abs(motor_angle(t, joint_angle(t, motor)) - motor) <= 1e-12


def test_linkage_out_of_reach_is_nan():
    t = linkage()
    # stretched: A on the line through O and B, OA = BO + AB; the joint angle has a vertical tangent there
    stretched = t.phi0_rad - math.asin(0.035 / 0.130)
    limit = motor_angle(t, stretched)
    assert joint_angle(t, limit * (1 - 1e-12)) == pytest.approx(stretched, abs=1e-4)
    assert math.isnan(joint_angle(t, limit * (1 + 1e-12)))
    open_linkage = linkage((0.002, 0.050, 0.040, 0.035, 84.75))
    assert math.isnan(motor_angle(open_linkage, math.pi))  # AC - BO sin phi = 75 mm, longer than the coupler


def closes_with_one_sign(dimensions):
    """By sampling: (smallest margin of the closure, smallest and largest turning factor), 4001 angles."""
    _, AB, BO, AC, BOF = dimensions
    phi = math.pi - math.radians(BOF) - np.linspace(-RANGE, RANGE, 4001)
    x, y = BO * np.cos(phi), BO * np.sin(phi)
    left = AB**2 - (AC - y) ** 2
    if left.min() <= 0.0:
        return left.min() / AB**2, 0.0, 0.0
    factor = y - (AC - y) * x / np.sqrt(left)
    return left.min() / AB**2, factor.min() / BO, factor.max() / BO


def test_linkages_are_refused_exactly_where_they_fail():
    rng = random.Random(5)
    counts = {lib.TL_OK: 0, lib.TL_ERR_RANGE: 0}
    for _ in range(3000):
        lengths = [rng.uniform(0.02, 0.12) for _ in range(3)]
        dimensions = (0.002, *lengths, rng.uniform(-180.0, 180.0))
        closure, low, high = closes_with_one_sign(dimensions)
        status = refusal(lib.tl_transmission_screw_linkage, ffi.new("tl_screw_linkage *", dimensions))
        if min(abs(closure), abs(low) or 1.0, abs(high) or 1.0) < 1e-5:
            continue  # too near the edge for sampling to decide
        assert status == (lib.TL_OK if closure > 0 and low * high > 0 else lib.TL_ERR_RANGE), dimensions
        counts[status] += 1
    assert min(counts.values()) > 500


@pytest.mark.parametrize("place", range(5))
def test_linkage_dimensions_must_be_physical(place):
    zero_is_legal, negative_is_legal = place >= 3, place == 4
    bad = [math.nan, math.inf, -math.inf] + [0.0] * (not zero_is_legal) + [-0.04] * (not negative_is_legal)
    for value in bad:
        dimensions = list(EXAMPLE_LINKAGE)
        dimensions[place] = value
        arguments = ffi.new("tl_screw_linkage *", dimensions)
        assert refusal(lib.tl_transmission_screw_linkage, arguments) == lib.TL_ERR_RANGE


def test_linkage_folding_onto_the_joint_is_refused():
    # AB = BO and AC = 0: for a crank beyond a right angle the nut rests on O and turns nothing
    assert refusal(
        lib.tl_transmission_screw_linkage, ffi.new("tl_screw_linkage *", (0.002, 0.04, 0.04, 0.0, 30.0))
    ) == lib.TL_ERR_RANGE  # fmt: skip


# ---- fixed ratio ---------------------------------------------------------------


def test_fixed_ratio():
    t = fixed(-51.0)
    assert motor_angle(t, 0.25) == -12.75
    assert joint_angle(t, -12.75) == 0.25
    assert ratio(t, 0.25) == (-51.0, 0.0)
    for bad in (0.0, math.nan, math.inf):
        assert refusal(lib.tl_transmission_fixed, bad) == lib.TL_ERR_RANGE


# ---- table -----------------------------------------------------------------------


def derivatives_of_linkage(order):
    """Largest |d^k motor / d q^k| over +-0.6 rad for k = 0..order, by mpmath."""
    largest = [mpf(0)] * (order + 1)
    with mp.workdps(40):
        for q in np.linspace(-0.6, 0.6, 301):
            taylor = mp.taylor(lambda x: motor_by_closure(EXAMPLE_LINKAGE, x), mpf(q), order)
            here = [abs(c) * mp.factorial(k) for k, c in enumerate(taylor)]
            largest = [max(pair) for pair in zip(largest, here)]
    return [float(x) for x in largest]


def table_error(approximation, reference, q):
    motor = max(abs(motor_angle(approximation, x) - motor_angle(reference, x)) for x in q)
    slopes = max(abs(ratio(approximation, x)[0] - ratio(reference, x)[0]) for x in q)
    return motor, slopes


def test_table_error_follows_the_fourth_power_of_the_step():
    """Cubic Hermite: error <= h^4 / 384 max f'''' (de Boor 1978), with f = motor angle and f = ratio."""
    reference = linkage()
    largest = derivatives_of_linkage(5)
    q = np.linspace(-0.6, 0.6, 12001)
    before = None
    print()
    for knots in (9, 17, 33, 65):
        approximation, _keep = table(reference, knots)
        step = 1.2 / (knots - 1)
        errors = table_error(approximation, reference, q)
        print(f"table of {knots:3d} knots: motor {errors[0]:.2e} rad, ratio {errors[1]:.2e}")
        for error, derivative in zip(errors, largest[4:]):
            bound = step**4 / 384 * derivative
            assert error <= bound * (1 + 1e-4) + 100 * EPS * 126
            assert error >= 0.5 * bound  # the bound is sharp where the derivative is largest
        if before:
            for old, new in zip(before, errors):
                assert 14.0 < old / new < 18.0
        before = errors


def test_table_knots_and_continuity():
    reference = linkage()
    t, knot = table(reference, 13)
    for i in range(13):
        q = -0.6 + i * (1.2 / 12)
        assert motor_angle(t, q) == pytest.approx(knot[i].motor_rad, rel=1e-13, abs=1e-13)
        assert ratio(t, q) == pytest.approx((knot[i].ratio, knot[i].ratio_slope), rel=1e-12)
        # no jump: motor, ratio and slope themselves slope by some hundred at most
        for side in (-1e-9,) * (i > 0) + (1e-9,) * (i < 12):
            assert motor_angle(t, q + side) == pytest.approx(knot[i].motor_rad, abs=2e-7)
            assert ratio(t, q + side) == pytest.approx((knot[i].ratio, knot[i].ratio_slope), abs=2e-6)


def test_table_slope_is_the_derivative_of_its_ratio():
    """Gauss's two points integrate the slope, a parabola, without error."""
    t, _keep = table(linkage(), 13)
    rng = np.random.default_rng(2)
    for i in range(12):
        low, high = -0.6 + (i + np.sort(rng.uniform(0.0, 1.0, 2))) * 0.1
        middle, half = (low + high) / 2, (high - low) / 2
        integral = half * sum(ratio(t, middle + s * half / math.sqrt(3.0))[1] for s in (-1, 1))
        assert integral == pytest.approx(ratio(t, high)[0] - ratio(t, low)[0], rel=1e-9, abs=1e-12)


def test_refused_tables():
    _, knot = table(linkage(), 9)

    def status(change=None, n=9, first=-0.6, step=0.15):
        changed = ffi.new("tl_table_knot[]", [(k.motor_rad, k.ratio, k.ratio_slope) for k in knot])
        if change:
            setattr(changed[change[0]], change[1], change[2])
        return refusal(lib.tl_transmission_table, changed, n, first, step)

    assert status() == lib.TL_OK
    assert status(n=1) == lib.TL_ERR_ARGUMENT
    for step in (0.0, -0.15, math.nan, math.inf):
        assert status(step=step) == lib.TL_ERR_RANGE
    assert status(first=math.nan) == lib.TL_ERR_RANGE
    for field in ("motor_rad", "ratio", "ratio_slope"):
        for i in (0, 4, 8):
            assert status((i, field, math.nan)) == lib.TL_ERR_RANGE
            assert status((i, field, math.inf)) == lib.TL_ERR_RANGE
    assert status((4, "ratio", -100.0)) == lib.TL_ERR_RANGE  # changes sign
    assert status((4, "ratio", 1000.0)) == lib.TL_ERR_RANGE  # the cubic overshoots
    assert status((4, "motor_rad", -500.0)) == lib.TL_ERR_RANGE  # turns back
    assert status((4, "ratio_slope", 1e5)) == lib.TL_ERR_RANGE  # the ratio may dip below 0


def test_refused_tabulation():
    knot = ffi.new("tl_table_knot[3]")
    assert lib.tl_transmission_tabulate(linkage(), -0.5, 0.5, knot, 1) == lib.TL_ERR_ARGUMENT
    assert lib.tl_transmission_tabulate(linkage(), 0.5, 0.5, knot, 3) == lib.TL_ERR_RANGE
    assert lib.tl_transmission_tabulate(linkage(), -0.5, math.nan, knot, 3) == lib.TL_ERR_RANGE


# ---- Fourier series ---------------------------------------------------------------


def random_series(seed, order):
    """A rising series (10): a steep ramp's harmonics with a random tail."""
    rng = np.random.default_rng(seed)
    a = rng.uniform(-3.0, 3.0, order + 1) / 2.0 ** np.arange(order + 1)
    b = 120.0 / np.arange(1, order + 1) ** 3 + rng.uniform(-1.0, 1.0, order) / 2.0 ** np.arange(order)
    return 1.1, list(a), list(b)


def test_series_is_the_sum_of_its_harmonics():
    omega, a, b = random_series(3, 8)
    t = fourier(omega, a, b)
    with mp.workdps(40):
        for q in np.linspace(-RANGE, RANGE, 101):
            x = mpf(q)

            def curve(x):
                angles = [j * mpf(omega) * x for j in range(1, 9)]
                return a[0] + sum(a[j] * mp.cos(y) + b[j - 1] * mp.sin(y) for j, y in enumerate(angles, 1))

            exact = [mp.diff(curve, x, k, h=mpf(10) ** -12) for k in range(3)]
            got = (motor_angle(t, q), *ratio(t, q))
            # each harmonic: rotation (j roundings) and product; (j omega)^k grows with the derivative
            for k in range(3):
                size = sum((j * omega) ** k * j * (abs(a[j]) + abs(b[j - 1])) for j in range(1, 9))
                assert abs(got[k] - exact[k]) <= 4 * EPS * (size + abs(a[0]))


def fit(t, n, harmonics, low, high):
    size = lib.tl_fourier_fit_workspace(n, harmonics)
    work, out = ffi.new("double[]", size), ffi.new("tl_fourier *")
    check(lib.tl_fourier_fit(t, RANGE, n, harmonics, low, high, work, size, out))
    return out


@pytest.mark.parametrize("order", [2, 3, 4])
def test_fit_finds_a_series_again(order):
    omega, a, b = random_series(order, order)
    truth = fourier(omega, a, b)
    found = fit(truth, 401, order, 0.83, 1.57)  # no point of the scan is at omega
    assert found.omega == pytest.approx(omega, abs=1e-7)
    again = ffi.new("tl_transmission *")
    check(lib.tl_transmission_fourier(again, found))
    # nearly dependent columns leave the coefficients loose, never the curve
    for q in ANGLES:
        assert motor_angle(again, q) == pytest.approx(motor_angle(truth, q), abs=1e-9)
    assert [*found.a][order + 1 :] == [0.0] * (8 - order) and [*found.b][order:] == [0.0] * (8 - order)


def tail_of_full_turn(order):
    """What the example linkage's own Fourier series, over its full turn, holds beyond `order`: it bounds
    the error that a series of base frequency 1 can have anywhere, hence the best fit's RMS error."""
    n = 4096
    _, AB, BO, AC, BOF = EXAMPLE_LINKAGE
    phi = math.pi - math.radians(BOF) - 2 * np.pi * np.arange(n) / n
    x, y = BO * np.cos(phi), BO * np.sin(phi)
    motor = 2 * np.pi / EXAMPLE_LINKAGE[0] * (x + np.sqrt(AB**2 - (AC - y) ** 2))
    size = 2.0 / n * np.abs(np.fft.rfft(motor))
    return math.sqrt(2.0) * size[order + 1 :].sum()


def best_by_numpy(t, order, omega, q):
    """Largest motor error of numpy's least squares at this omega."""
    phase = omega * np.outer(q, np.arange(1, order + 1))
    columns = np.hstack([np.ones((len(q), 1)), np.cos(phase), np.sin(phase)])
    motor = np.array([motor_angle(t, x) for x in q])
    return np.abs(columns @ np.linalg.lstsq(columns, motor, rcond=1e-14)[0] - motor).max()


def test_fit_of_the_linkage_by_order():
    t = linkage()
    before = math.inf
    print()
    for order in (3, 4, 5, 6, 7, 8):
        series = ffi.new("tl_transmission *")
        check(lib.tl_transmission_fourier(series, fit(t, 1001, order, 0.5, 1.5)))
        errors = np.array([motor_angle(series, q) - motor_angle(t, q) for q in ANGLES])
        ratios = np.array([[ratio(series, q)[0], ratio(t, q)[0]] for q in ANGLES])
        absolute = np.abs(ratios[:, 0] - ratios[:, 1]).max()
        relative = np.abs(ratios[:, 0] / ratios[:, 1] - 1).max()
        print(
            f"order {order}, omega {series.fourier.omega:.4f}: motor {np.abs(errors).max():.2e} rad, "
            f"ratio {absolute:.2e} (relative {relative:.2e}); the paper's order 8: ratio 2.43e-03"
        )
        rounding = 64 * EPS * 64.5  # of motor angles up to 64.5 rad and coefficients of their size
        assert np.sqrt(np.mean(errors**2)) <= tail_of_full_turn(order) + rounding
        assert np.abs(errors).max() <= 1.05 * best_by_numpy(t, order, series.fourier.omega, ANGLES) + rounding
        assert np.abs(errors).max() <= before + rounding
        before = np.abs(errors).max()


def test_fit_refusals():
    t, out = linkage(), ffi.new("tl_fourier *")
    work = ffi.new("double[]", 19 * 100)

    def status(range_rad=RANGE, n=100, harmonics=8, low=0.5, high=1.5, room=19 * 100):
        return lib.tl_fourier_fit(t, range_rad, n, harmonics, low, high, work, room, out)

    assert status() == lib.TL_OK
    assert lib.tl_fourier_fit_workspace(100, 8) == 1900
    out.omega = 7.0
    assert status(harmonics=0) == status(harmonics=9) == lib.TL_ERR_ARGUMENT
    assert lib.tl_fourier_fit_workspace(100, 9) == 0
    assert status(n=16) == lib.TL_ERR_TOO_SHORT
    assert status(room=1899) == lib.TL_ERR_WORKSPACE
    for bad in ({"range_rad": 0.0}, {"low": 0.0}, {"low": 2.0}, {"high": math.inf}, {"range_rad": math.nan}):
        assert status(**bad) == lib.TL_ERR_RANGE
    assert status(range_rad=3.1) == lib.TL_OK  # the example linkage turns all the way round
    assert out.omega != 7.0


def test_fit_over_angles_where_the_linkage_is_open():
    out, work = ffi.new("tl_fourier *"), ffi.new("double[]", 1900)
    open_linkage = linkage((0.002, 0.050, 0.040, 0.035, 84.75))
    out.omega = 7.0
    status = lib.tl_fourier_fit(open_linkage, 3.1, 100, 8, 0.5, 1.5, work, 1900, out)
    assert status == lib.TL_ERR_NOT_FINITE
    assert out.omega == 7.0


def test_refused_series():
    omega, a, b = random_series(3, 8)

    def status(**change):
        values = {"omega": omega, "a": a, "b": b, **change}
        return refusal(lib.tl_transmission_fourier, ffi.new("tl_fourier *", values))

    assert status() == lib.TL_OK
    for bad in (0.0, -1.0, math.nan, math.inf):
        assert status(omega=bad) == lib.TL_ERR_RANGE
    assert status(a=[math.nan] + a[1:]) == lib.TL_ERR_RANGE
    assert status(b=b[:7] + [math.inf]) == lib.TL_ERR_RANGE
    # cos(6 q) changes sign at 15 degrees
    assert status(omega=6.0, a=[0.0] * 9, b=[1.0] + [0.0] * 7) == lib.TL_ERR_RANGE


# ---- what all kinds share -----------------------------------------------------------


KINDS = {
    "fixed": lambda: (fixed(51.0), None),
    "linkage": lambda: (linkage(), None),
    "fourier": lambda: (fourier(*random_series(3, 8)), None),
    "table": lambda: table(linkage(), 33, -RANGE, RANGE),
    "negative table": lambda: table(linkage(LINKAGES[3]), 33),
}


@pytest.fixture(params=KINDS)
def any_kind(request):
    """A transmission; the knots of a table live as long as the test."""
    t, _knots = KINDS[request.param]()
    yield t


def test_round_trip(any_kind):
    t = any_kind
    for q in np.linspace(-RANGE, RANGE, 1001):
        motor = motor_angle(t, q)
        assert abs(joint_angle(t, motor) - q) <= 1e-12
        assert abs(motor_angle(t, joint_angle(t, motor)) - motor) <= 1e-12


@pytest.mark.parametrize("kind", ["fixed", "linkage", "fourier"])
def test_ratio_is_the_derivative(kind):
    """The change of motor angle and ratio over a step is the integral of ratio and slope (Gauss, 8 points).
    A table's slope is tested above; its ratio is its motor angle's derivative to their errors only."""
    t = KINDS[kind]()[0]
    nodes, weights = np.polynomial.legendre.leggauss(8)
    step = 2 * RANGE / 32
    for i in range(32):
        low, high = -RANGE + step * i, -RANGE + step * (i + 1)
        values = np.array([ratio(t, low + 0.5 * step * (x + 1)) for x in nodes])
        motor = motor_angle(t, high) - motor_angle(t, low)
        assert 0.5 * step * weights @ values[:, 0] == pytest.approx(motor, abs=1e-12)
        change = ratio(t, high)[0] - ratio(t, low)[0]
        assert 0.5 * step * weights @ values[:, 1] == pytest.approx(change, abs=1e-11)


def test_sin_and_cos_at_hand_give_the_same_bits(any_kind):
    t = any_kind
    out = ffi.new("double[4]")
    for q in np.linspace(-RANGE, RANGE, 101):
        lib.tl_sincos(q, out, out + 1)
        lib.tl_transmission_ratio_sc(t, q, out[0], out[1], out + 2, out + 3)
        assert (out[2], out[3]) == ratio(t, q)


def test_nan_stays_nan(any_kind):
    t = any_kind
    assert math.isnan(motor_angle(t, math.nan))
    assert math.isnan(joint_angle(t, math.nan))
    if t.kind != lib.TL_TRANSMISSION_FIXED:
        assert all(map(math.isnan, ratio(t, math.nan)[:1]))
    motion = ffi.new("double[3]")
    lib.tl_transmission_joint_motion(t, [math.nan, 0.0, 0.0], motion)
    assert math.isnan(motion[0])


def test_joint_motion(any_kind):
    """A joint's known motion, turned into the motor's by differences of the closed curve, and back."""
    t = any_kind
    nodes = np.array([-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0])
    first = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0  # central differences of sixth order
    second = np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / 180.0
    h = 2e-3
    # differences: rounding of 64 rad / h^2 over a ratio of 100. The curvature of a table's motor angle errs
    # by step^2 / 12 times its fourth derivative (0.02, at a ratio of 100); its slope errs by itself
    tolerance = 1e-3 if t.kind == lib.TL_TRANSMISSION_TABLE else 1e-9
    for at in np.linspace(0.0, 6.0, 25):

        def joint(time):
            return 0.9 * RANGE * np.sin(time), 0.9 * RANGE * np.cos(time), -0.9 * RANGE * np.sin(time)

        motor = np.array([motor_angle(t, joint(at + k * h)[0]) for k in nodes])
        motion = ffi.new("double[3]")
        lib.tl_transmission_joint_motion(t, [motor[3], first @ motor / h, second @ motor / h**2], motion)
        assert np.allclose([*motion], joint(at), rtol=0.0, atol=tolerance)


def test_approximations_go_on_straight_beyond_their_range():
    narrow, _keep = table(linkage(), 33, -RANGE, RANGE)
    for t in (narrow, fourier(*random_series(3, 8))):
        for edge in (-RANGE, RANGE):
            at_edge = ratio(t, edge)[0]
            for far in (1e-6, 0.1, 3.0):
                q = edge + math.copysign(far, edge)
                assert ratio(t, q) == (pytest.approx(at_edge, rel=1e-12), 0.0)
                straight = motor_angle(t, edge) + at_edge * (q - edge)
                assert motor_angle(t, q) == pytest.approx(straight, rel=1e-12)
                assert joint_angle(t, motor_angle(t, q)) == pytest.approx(q, abs=1e-12)


def test_error_report():
    worst = ffi.new("double[2]")
    exact = linkage()
    lib.tl_transmission_error(exact, exact, RANGE, 101, worst, worst + 1)
    assert (worst[0], worst[1]) == (0.0, 0.0)
    coarse, _keep = table(exact, 9)
    lib.tl_transmission_error(coarse, exact, RANGE, 1001, worst, worst + 1)
    motor = max(abs(motor_angle(coarse, q) - motor_angle(exact, q)) for q in ANGLES)
    relative = max(abs(ratio(coarse, q)[0] / ratio(exact, q)[0] - 1) for q in ANGLES)
    assert worst[0] == pytest.approx(motor, rel=1e-6) and worst[1] == pytest.approx(relative, rel=1e-6)
    # a linkage that is open somewhere in the range is no approximation at all
    lib.tl_transmission_error(linkage((0.002, 0.050, 0.040, 0.035, 84.75)), exact, 3.1, 101, worst, worst + 1)
    assert math.isnan(worst[0]) and math.isnan(worst[1])


def test_null_pointers_are_refused():
    t = ffi.new("tl_transmission *")
    for call in (lib.tl_transmission_screw_linkage, lib.tl_transmission_fourier):
        assert call(t, ffi.NULL) == lib.TL_ERR_ARGUMENT
    assert lib.tl_transmission_table(t, ffi.NULL, 9, 0.0, 0.1) == lib.TL_ERR_ARGUMENT
    with pytest.raises(TalusError):
        check(lib.tl_transmission_fixed(ffi.NULL, 1.0))
