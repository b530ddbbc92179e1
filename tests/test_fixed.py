"""Fixed-point operations against exact whole numbers, sine and cosine against NumPy, over the whole input range."""

from fractions import Fraction
from math import floor

import numpy
import pytest
from talus import ffi, lib

LOW, HIGH = -(2**31), 2**31 - 1
EDGES = [LOW, LOW + 1, -(2**30), -1, 0, 1, 2**30, HIGH - 1, HIGH]


def some(n, seed):
    """Whole numbers of every size and sign, and the ends of the range."""
    rng = numpy.random.default_rng(seed)
    sizes = rng.integers(1, 32, n)
    return EDGES + [int(x) >> (32 - int(s)) for x, s in zip(rng.integers(LOW, HIGH + 1, n), sizes, strict=True)]


def held(x):
    return max(LOW, min(HIGH, x))


def flag():
    return ffi.new("uint32_t *")


def test_saturate_holds_and_flags():
    for x in [*EDGES, LOW - 1, HIGH + 1, -(2**63), 2**63 - 1]:
        saturated = flag()
        assert lib.tl_fixed_saturate(x, saturated) == held(x)
        assert saturated[0] == (held(x) != x)


@pytest.mark.parametrize("drop", [1, 15, 21, 25, 31, 32, 61, 62])
def test_multiply_rounds_to_nearest_and_never_wraps(drop):
    for a, b in [*zip(some(2000, 1), some(2000, 2), strict=True), *((a, b) for a in EDGES for b in EDGES)]:
        saturated = flag()
        exact = floor(Fraction(a * b, 2**drop) + Fraction(1, 2))
        assert lib.tl_fixed_multiply(a, b, drop, saturated) == held(exact)
        assert saturated[0] == (held(exact) != exact)


def test_sine_and_cosine_over_the_whole_range():
    sine, cosine = ffi.new("int32_t *"), ffi.new("int32_t *")
    rng = numpy.random.default_rng(3)
    quarters = [round(k * numpy.pi / 4 * 2**29) + d for k in range(-5, 6) for d in (-1, 0, 1)]
    angles = [*EDGES, *(x for x in quarters if LOW <= x <= HIGH), *map(int, rng.integers(LOW, HIGH + 1, 100000))]
    got = numpy.empty((2, len(angles)))
    for i, angle in enumerate(angles):
        lib.tl_fixed_sincos(angle, sine, cosine)
        got[:, i] = sine[0], cosine[0]
    true = numpy.array(angles) / 2.0**29
    assert numpy.abs(got[0] / 2**31 - numpy.sin(true)).max() <= 1.6e-9
    assert numpy.abs(got[1] / 2**31 - numpy.cos(true)).max() <= 1.6e-9


def test_from_and_to_double():
    for q in (0, 15, 21, 31):
        for x in some(500, 4):
            assert lib.tl_fixed_to_double(x, q) == float(Fraction(x, 2**q))
            saturated = flag()
            assert lib.tl_fixed_from_double(x / 2**q, q, saturated) == x and not saturated[0]
    for x, expected in ((1.0, HIGH), (-1.1, LOW), (float("inf"), HIGH), (float("-inf"), LOW), (float("nan"), 0)):
        saturated = flag()
        assert lib.tl_fixed_from_double(x, 31, saturated) == expected and saturated[0] == 1
