"""talus/math.h against mpmath: the stated bounds, over dense and adversarial inputs."""

import math
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mpmath import mp, mpf
from talus import ffi, lib

REPOSITORY = Path(__file__).resolve().parents[1]
RANDOM = np.random.default_rng(7)
INF, NAN = math.inf, math.nan
TINY = [5e-324, 1e-310, 2.2250738585072014e-308, 1e-200, 1e-30, 1e-9, 1e-8, 1.5e-8]


@pytest.fixture(autouse=True)
def precision():
    with mp.workprec(140):
        yield


def neighbours(values, reach=2):
    """Each value and the doubles next to it, both signs."""
    out = []
    for value in values:
        x = value
        for _ in range(reach):
            x = math.nextafter(x, -INF)
        for _ in range(2 * reach + 1):
            out += [x, -x]
            x = math.nextafter(x, INF)
    return out


def log_uniform(low, high, n):
    return (10.0 ** RANDOM.uniform(math.log10(low), math.log10(high), n)).tolist()


def both_signs(values):
    return [s * v for v in values for s in (1.0, -1.0)]


def worst(function, reference, inputs, relative=True, floor=0.0):
    """Largest error over the inputs and where; `floor` is the smallest size errors are measured by."""
    largest, at = mpf(0), None
    for x in inputs:
        arguments = x if isinstance(x, tuple) else (x,)
        exact = reference(*(mpf(a) for a in arguments))
        got = function(*arguments)
        assert math.isfinite(got), (x, got)
        error = abs(mpf(got) - exact)
        if relative and error:
            error /= max(abs(exact), mpf(floor))
        if error > largest:
            largest, at = error, x
    return float(largest), at


def sincos(x):
    out = ffi.new("double[2]")
    lib.tl_sincos(x, out, out + 1)
    return out[0], out[1]


def same_bits(a, b):
    """NaNs count as one value: IEEE 754 leaves their bits open."""
    return struct.pack("d", a) == struct.pack("d", b) or (math.isnan(a) and math.isnan(b))


def circle_inputs(limit):
    return (
        RANDOM.uniform(-limit, limit, 4000).tolist()
        + both_signs(log_uniform(1e-12, limit, 3000))
        + neighbours([k * math.pi / 4 for k in range(1, 200)])
        + neighbours([limit, 1e5] if limit >= 1e5 else [limit], 1)
        + both_signs(TINY)
    )


# |x| <= 1e5 is reduced in one way, larger ones in another: 1e5 and its neighbours are in both sets
@pytest.mark.parametrize("limit", [0.8, 7.0, 99_999.0, 999_999_999.0])
def test_sin_and_cos_within_their_bound(limit):
    inputs = circle_inputs(limit)
    assert worst(lib.tl_sin, mp.sin, inputs, relative=False)[0] <= 1.9e-16
    assert worst(lib.tl_cos, mp.cos, inputs, relative=False)[0] <= 1.9e-16


def nearest_to_multiples(last):
    """(k, the double nearest to k pi/2, k pi/2 - that double) for k = 1..last, in exact integers."""
    bits = 240
    with mp.workprec(400):
        half_pi = int(mp.floor(mp.pi / 2 * mpf(2) ** bits))
    for k in range(1, last + 1):
        exact = k * half_pi
        x = exact / (1 << bits)  # correctly rounded division of integers
        numerator, denominator = x.as_integer_ratio()
        yield k, x, (exact - numerator * ((1 << bits) // denominator)) / (1 << bits)


def test_sin_cos_tan_nearest_to_every_multiple_of_half_pi_up_to_1e5():
    # there sin and cos are -rest, 1 or their like: with |rest| < 2^-36, rest^2/2 and
    # rest^3/3 are below half an ulp of what they are added to
    worst_tan = 0.0
    for k, x, rest in nearest_to_multiples(63661):
        s, c = sincos(x)
        sign = (1, 1, -1, -1)[k % 4]
        sign_next = (1, -1, -1, 1)[k % 4]
        exact_s, exact_c = (sign, sign * rest) if k % 2 else (-sign_next * rest, sign_next)
        assert abs(s - exact_s) <= 1.9e-16 and abs(c - exact_c) <= 1.9e-16, (k, x)
        tan = lib.tl_tan(x) if k % 2 == 0 else 1 / lib.tl_tan(x)
        exact_tan = -rest if k % 2 == 0 else rest
        worst_tan = max(worst_tan, abs(tan / exact_tan - 1))
    assert worst_tan <= 1e-15


def test_sincos_has_the_bits_of_sin_and_cos():
    for x in circle_inputs(9e8) + [NAN, INF, 0.0, -0.0]:
        s, c = sincos(x)
        assert same_bits(s, lib.tl_sin(x)) and same_bits(c, lib.tl_cos(x))


def test_sin_cos_tan_symmetries_and_special_values():
    for x in circle_inputs(9e8):
        assert same_bits(lib.tl_sin(-x), -lib.tl_sin(x))
        assert same_bits(lib.tl_cos(-x), lib.tl_cos(x))
        assert same_bits(lib.tl_tan(-x), -lib.tl_tan(x))
    for function in (lib.tl_sin, lib.tl_tan):
        assert same_bits(function(0.0), 0.0) and same_bits(function(-0.0), -0.0)
    assert lib.tl_cos(0.0) == lib.tl_cos(-0.0) == 1.0
    for function in (lib.tl_sin, lib.tl_cos, lib.tl_tan):
        for x in (NAN, INF, -INF, 1.0000001e9, -1e300):
            assert math.isnan(function(x))
        assert math.isfinite(function(1e9))


def test_sin_is_relatively_exact_near_zero():
    inputs = both_signs(log_uniform(1e-300, 0.7, 2000)) + both_signs(TINY)
    assert worst(lib.tl_sin, mp.sin, inputs, floor=2.3e-308)[0] <= 2.3e-16


def test_tan_within_its_bound():
    inputs = circle_inputs(99_999.0)
    assert worst(lib.tl_tan, mp.tan, inputs, floor=2.3e-308)[0] <= 1e-15


def test_atan2_within_its_bound():
    n = 3000
    angles = RANDOM.uniform(-math.pi, math.pi, n)
    sizes = 10.0 ** RANDOM.uniform(-150, 150, n)
    inputs = list(zip((sizes * np.sin(angles)).tolist(), (sizes * np.cos(angles)).tolist()))
    # around the places where the reduction changes: slope 1/2, 1, 2, and the axes
    for slope in (0.5, 1.0, 2.0, 1e-8, 1e8):
        for y in neighbours([slope], 3):
            inputs += [(y, 1.0), (y, -1.0), (y * 3e300 if slope < 4 else y, 3e300 if slope < 4 else 1.0)]
    inputs += [(s * a, t * b) for a in TINY for b in TINY + [1.0] for s in (1, -1) for t in (1, -1)]
    inputs += [(1.7e308, 1.7e308), (-1.7e308, 1.1e308), (5e307, -1.7e308)]
    assert worst(lib.tl_atan2, mp.atan2, inputs, floor=2.3e-308)[0] <= 5e-16


def test_atan2_special_values():
    for y in (0.0, -0.0, 1.0, -1.0, 2.5, INF, -INF):
        for x in (0.0, -0.0, 1.0, -1.0, 0.3, INF, -INF):
            expected = math.atan2(y, x)
            got = lib.tl_atan2(y, x)
            assert got == pytest.approx(expected, rel=3e-16, abs=0), (y, x)
            assert math.copysign(1, got) == math.copysign(1, expected), (y, x)
    for pair in ((NAN, 1.0), (1.0, NAN), (NAN, INF), (0.0, NAN)):
        assert math.isnan(lib.tl_atan2(*pair))


def test_asin_and_acos_within_their_bounds():
    edges = neighbours([0.5, 0.7071067811865476, 0.9999], 3) + both_signs(TINY)
    near_one = [1.0 - d for d in log_uniform(1e-16, 1e-2, 400)] + [1.0, math.nextafter(1.0, 0.0)]
    inputs = RANDOM.uniform(-1, 1, 4000).tolist() + edges + both_signs(near_one)
    assert worst(lib.tl_asin, mp.asin, inputs, relative=False)[0] <= 5e-16
    assert worst(lib.tl_acos, mp.acos, inputs, relative=False)[0] <= 5e-16
    # and relative where the result is small
    assert worst(lib.tl_asin, mp.asin, both_signs(log_uniform(1e-300, 0.5, 1000)))[0] <= 5e-16
    assert worst(lib.tl_acos, mp.acos, near_one[:-2])[0] <= 5e-16
    assert lib.tl_acos(1.0) == 0.0 and lib.tl_acos(-1.0) == math.pi
    assert same_bits(lib.tl_asin(-0.0), -0.0) and same_bits(lib.tl_asin(0.0), 0.0)
    for x in (1.0000000000000002, -1.0000000000000002, 2.0, INF, -INF, NAN):
        assert math.isnan(lib.tl_asin(x)) and math.isnan(lib.tl_acos(x))


def test_exp_within_its_bound():
    # near odd multiples of ln(2)/2 the reduced argument is largest
    turns = neighbours([(k + 0.5) * math.log(2) for k in range(0, 1000, 7)], 1)
    inputs = (
        RANDOM.uniform(-708, 709.7, 5000).tolist() + both_signs(log_uniform(1e-20, 1, 500)) + both_signs(TINY)
    )
    inputs += [x for x in turns if -708 < x < 709] + [709.782712893384, -708.3964185322641]
    assert worst(lib.tl_exp, mp.exp, inputs)[0] <= 3e-16


def test_exp_underflow_overflow_and_special_values():
    for x in RANDOM.uniform(-745.1, -708.5, 500).tolist():
        # half of the smallest subnormal, and the rounding before the last scaling
        assert abs(mpf(lib.tl_exp(x)) - mp.exp(x)) <= mpf(5e-324) * mpf(0.5) + mp.exp(x) * mpf(3e-16)
    assert lib.tl_exp(-745.1332191019411) == 5e-324
    assert lib.tl_exp(-745.2) == lib.tl_exp(-1e308) == lib.tl_exp(-INF) == 0.0
    assert lib.tl_exp(709.79) == lib.tl_exp(746.0) == lib.tl_exp(INF) == INF
    assert lib.tl_exp(0.0) == lib.tl_exp(-0.0) == 1.0
    assert math.isnan(lib.tl_exp(NAN))


def test_log_within_its_bound():
    inputs = log_uniform(1e-307, 1e308, 3000) + RANDOM.uniform(0.5, 2.0, 3000).tolist()
    inputs += [1.0 + s * d for d in log_uniform(3e-16, 1e-1, 1000) for s in (1, -1) if 1.0 + s * d != 1.0]
    inputs += [x for x in neighbours([0.7071067811865476, 1.4142135623730951, 2.0, 0.5, 1024.0]) if x > 0]
    inputs += [5e-324, 1e-320, 3e-310, 2.2250738585072014e-308, 1.7976931348623157e308]
    assert worst(lib.tl_log, mp.log, inputs)[0] <= 3e-16


def test_log_special_values():
    assert same_bits(lib.tl_log(1.0), 0.0)
    assert lib.tl_log(0.0) == lib.tl_log(-0.0) == -INF and lib.tl_log(INF) == INF
    for x in (-1.0, -5e-324, -INF, NAN):
        assert math.isnan(lib.tl_log(x))


def test_pow_within_its_bound():
    n = 4000
    x = log_uniform(1e-20, 1e20, n) + RANDOM.uniform(0.5, 2.0, n).tolist()
    y = RANDOM.uniform(-15, 15, n).tolist() + RANDOM.uniform(-300, 300, n).tolist()
    for a, b in zip(x, y):
        exact = mpf(a) ** mpf(b)
        if not 1e-307 < exact < 1e307:
            continue
        bound = 1e-15 * (1 + abs(mpf(b) * mp.log(a)))
        assert abs(mpf(lib.tl_pow(a, b)) / exact - 1) <= bound, (a, b)
        if b > 5:
            assert abs(mpf(lib.tl_pow(-a, 5.0)) / -(mpf(a) ** 5) - 1) <= 1e-15 * (1 + 5 * abs(mp.log(a)))
            assert abs(mpf(lib.tl_pow(-a, -4.0)) / mpf(a) ** -4 - 1) <= 1e-15 * (1 + 4 * abs(mp.log(a)))


def test_pow_special_values_are_those_of_c99_but_for_pow_of_1_and_nan():
    values = [0.0, -0.0, 1.0, -1.0, 2.0, -2.0, 0.5, -0.5, INF, -INF]
    exponents = [0.0, -0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 0.5, -0.5, INF, -INF]
    for x in values:
        for y in exponents:
            try:
                expected = math.pow(x, y)
            except (ValueError, ZeroDivisionError):
                expected = NAN if x < 0 else INF  # Python raises where C answers
                if x == 0 and math.copysign(1, x) < 0 and y in (-1.0, -3.0):
                    expected = -INF
            if x in (-INF,) and y in (0.5, -0.5):
                expected = NAN  # here, for every x < 0; C99 has +infinity and +0
            got = lib.tl_pow(x, y)
            if math.isnan(expected):
                assert math.isnan(got), (x, y, got)
            else:
                assert got == pytest.approx(expected, rel=1e-15), (x, y, got, expected)
                assert math.copysign(1, got) == math.copysign(1, expected), (x, y)
    assert lib.tl_pow(NAN, 0.0) == 1.0
    assert math.isnan(lib.tl_pow(NAN, 1.0)) and math.isnan(lib.tl_pow(1.0, NAN))
    assert math.isnan(lib.tl_pow(-2.0, 0.3))


def test_tanh_within_its_bound():
    inputs = RANDOM.uniform(-25, 25, 3000).tolist() + both_signs(log_uniform(1e-300, 3, 2000))
    inputs += neighbours([0.55, 22.0, 40.0]) + both_signs(TINY)
    assert worst(lib.tl_tanh, mp.tanh, inputs, floor=2.3e-308)[0] <= 1e-15
    assert lib.tl_tanh(INF) == lib.tl_tanh(800.0) == 1.0 and lib.tl_tanh(-INF) == -1.0
    assert same_bits(lib.tl_tanh(-0.0), -0.0) and math.isnan(lib.tl_tanh(NAN))


def test_same_bits_without_optimisation(tmp_path):
    """Another compiler setting, another instruction selection: the same numbers."""
    compiler = shutil.which("cc")
    assert compiler, "a C compiler is needed"
    plain = tmp_path / "libplain.so"
    subprocess.run(
        [
            compiler,
            "-std=c99",
            "-O0",
            "-ffp-contract=off",
            "-fPIC",
            "-shared",
            f"-I{REPOSITORY / 'include'}",
            str(REPOSITORY / "lib" / "math.c"),
            "-o",
            str(plain),
            "-lm",
        ],
        check=True,
    )
    other = ffi.dlopen(str(plain))
    inputs = RANDOM.normal(0, 3, 3000).tolist() + RANDOM.uniform(-1e6, 1e6, 1000).tolist() + [-0.0, NAN, INF]
    names = [n for n in ("sin", "cos", "tan", "asin", "acos", "exp", "log", "tanh")]
    for x in inputs:
        for name in names:
            assert same_bits(getattr(lib, "tl_" + name)(x), getattr(other, "tl_" + name)(x)), (name, x)
        assert same_bits(lib.tl_atan2(x, 0.7), other.tl_atan2(x, 0.7))
        assert same_bits(lib.tl_pow(abs(x), 1.3), other.tl_pow(abs(x), 1.3))


@pytest.mark.long
def test_coefficients_are_those_of_the_generator():
    header = (REPOSITORY / "lib" / "math_coefficients.h").read_text()
    script = REPOSITORY / "tools" / "math_coefficients.py"
    made = subprocess.run([sys.executable, str(script)], check=True, capture_output=True, text=True).stdout
    assert made == header
