"""The export's fast way to write numbers against Python's own, byte by byte."""

import numpy as np
import pytest
from talus.acquire_export import decimals


def pythons(values, places):
    line = ",".join(f"%.{n}f" for n in places) + "\n"
    return "".join(line % tuple(row) for row in values.tolist()).encode()


@pytest.mark.parametrize("seed", range(20))
def test_numbers_of_any_size(seed):
    generator = np.random.default_rng(seed)
    places = generator.integers(0, 13, 8).tolist()
    values = generator.standard_normal((3000, 8)) * 10.0 ** generator.integers(-14, 5, 8)
    values[generator.integers(0, 3000, 50), generator.integers(0, 8, 50)] = 0.0
    values[generator.integers(0, 3000, 50), generator.integers(0, 8, 50)] = -0.0
    assert decimals.lines(values, places) == pythons(values, places)


@pytest.mark.parametrize("places", range(13))
def test_near_the_half_between_two(places):
    """Numbers that are a half, exactly or but for the last bit, of either sign, in the last place."""
    generator = np.random.default_rng(places)
    half = (generator.integers(0, 10**4, 4000) + 0.5) / 10.0**places
    values = np.concatenate([half, -half, np.nextafter(half, 0), np.nextafter(half, 1e9), generator.integers(-4000, 4000, 4000) / 1024])[:, None]
    assert decimals.lines(values, [places]) == pythons(values, [places])


@pytest.mark.parametrize("odd", [1e300, -1e22, 2.0**53 + 2, np.inf, np.nan, 123456789012.345])
def test_what_the_fast_way_cannot_write(odd):
    values = np.array([[0.25, odd], [1e-3, -1.0]])
    assert decimals.lines(values, [3, 7]) == pythons(values, [3, 7])


def test_the_example_and_nothing():
    assert decimals.lines(np.array([[0.0, -1.5], [0.1, 2.25]]), [1, 3]) == b"0.0,-1.500\n0.1,2.250\n"
    assert decimals.lines(np.empty((0, 2)), [1, 3]) == b""
