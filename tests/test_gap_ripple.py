"""tools/talus/diagnosis/catalogue/ripple.py: which orders of a ripple are two."""

from types import SimpleNamespace

import numpy as np
import pytest
from talus.diagnosis.catalogue.ripple import FEWEST_WAVES_RAD, are_apart


def ripple(order, range_rad):
    return SimpleNamespace(phase_rad=order * range_rad)


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
    assert not are_apart(ripple(8, range_rad), ripple(9, range_rad)) and are_apart(ripple(8, range_rad), ripple(apart, range_rad))
    assert left_of_a_bumper([8, 9], range_rad) < 0.25 < left_of_a_bumper([8, apart], range_rad)


def test_many_turns_tell_neighbours_apart_and_no_order_is_apart_from_itself():
    turns_rad = 2 * np.pi * 8
    assert are_apart(ripple(11, turns_rad), ripple(12, turns_rad)) and are_apart(ripple(12, turns_rad), ripple(11, turns_rad))
    assert not are_apart(ripple(12, turns_rad), ripple(12, turns_rad))


def test_what_is_no_ripple_is_apart():
    """Modes of a mount."""
    mode = SimpleNamespace(phase_rad=None)
    assert are_apart(mode, mode) and are_apart(ripple(8, 1.0), mode)
