"""tools/talus/diagnosis/catalogue/ripple.py: which orders of a ripple are two."""

from types import SimpleNamespace

import numpy as np
import pytest
from talus.diagnosis.catalogue.ripple import FEWEST_WAVES_RAD, are_apart


def ripple(range_rad, *orders):
    return SimpleNamespace(phases_rad=tuple(order * range_rad for order in orders))


def left_of_a_bumper(orders, range_rad):
    """Share that ripples with overtones leave of a spring that begins in the middle, by NumPy's least squares beside a line and a constant."""
    x = np.linspace(0.0, range_rad, 2000)
    bumper = np.maximum(x - 0.5 * range_rad, 0.0) ** 2
    waves = [f(k * order * x) for order in orders for k in (1, 2) for f in (np.sin, np.cos)]
    plain = np.linalg.lstsq(np.column_stack([x**0, x]), bumper, rcond=None)[0] @ np.vstack([x**0, x])
    rows = np.column_stack([x**0, x, *waves])
    fitted = rows @ np.linalg.lstsq(rows, bumper, rcond=None)[0]
    return np.std(bumper - fitted) / np.std(bumper - plain)


@pytest.mark.parametrize("range_rad", [1.2, 1.28, 1.36])
def test_orders_that_are_two_do_not_make_a_bumper_and_neighbours_do(range_rad):
    """A motor that goes a fifth to a quarter of a turn: each order has gone through more than one period, the beat of neighbours has not."""
    apart = 8 + int(np.ceil(FEWEST_WAVES_RAD / range_rad)) + 1
    assert not are_apart(ripple(range_rad, 8), ripple(range_rad, 9)) and are_apart(ripple(range_rad, 8), ripple(range_rad, apart))
    assert left_of_a_bumper([8, 9], range_rad) < 0.25 < left_of_a_bumper([8, apart], range_rad)


def test_many_turns_tell_neighbours_apart_and_no_order_is_apart_from_itself():
    turns_rad = 2 * np.pi * 8
    assert are_apart(ripple(turns_rad, 11), ripple(turns_rad, 12)) and are_apart(ripple(turns_rad, 12), ripple(turns_rad, 11))
    assert not are_apart(ripple(turns_rad, 12), ripple(turns_rad, 12))


def test_an_overtone_is_an_order_as_well():
    range_rad = 1.36
    assert are_apart(ripple(range_rad, 8), ripple(range_rad, 17, 34)) and not are_apart(ripple(range_rad, 8, 16), ripple(range_rad, 17, 34))


def test_what_is_no_ripple_is_apart():
    """Modes of a mount."""
    assert are_apart(ripple(1.0), ripple(1.0)) and are_apart(ripple(1.0, 8), ripple(1.0))
