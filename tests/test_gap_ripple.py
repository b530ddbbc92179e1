"""tools/talus/diagnosis/catalogue/ripple.py: which orders of a ripple are two."""

from types import SimpleNamespace

import numpy as np
import pytest
import talus
import yaml
from support import REPOSITORY
from talus.diagnosis.catalogue.ripple import APART_RAD, are_apart


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
    apart = 8 + int(np.ceil(APART_RAD / range_rad)) + 1
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


def low_geared(turns):
    """The pendulum with a gear by which its motor goes so many turns."""
    tree = yaml.safe_load((REPOSITORY / "models/pendulum.yaml").read_text())
    range_rad = np.ptp(talus.simulate(talus.Model.from_tree(tree), duration_s=20, ideal=True).columns["joint_rad"])
    ratio = float(turns * 2 * np.pi / range_rad)
    tree["joint"]["torque_constant_Nm_A"] *= tree["joint"]["transmission"]["ratio"] / ratio
    tree["joint"]["transmission"]["ratio"] = ratio
    return tree


@pytest.mark.long
@pytest.mark.parametrize(("hidden", "parameters"), [
    ("kinematic_error", {"sine_Nm": 0.12, "cosine_Nm": -0.1, "per_turn": 1.0}),
    ("parallel_spring", {"stiffness_Nm_rad": 1.0, "stiffening_Nm_rad3": 2.0, "preload_Nm": 0.0, "bend_Nm_rad2": 0.0, "bumper_Nm_rad": 0.0,
                         "bumper_rad": 0.0, "bumper_side": 0}),
])  # fmt: skip
def test_a_ripple_of_little_more_than_one_turn_is_none_of_a_spring(hidden, parameters):
    """Nor a spring a ripple: over a turn and a quarter a bent spring has a ripple's hump, pushing away, where no true one does."""
    tree = low_geared(1.25)
    machine = talus.Model.from_tree({**tree, "effects": [{"effect": hidden, "joint": "joint", "parameters": parameters}]})
    found = talus.diagnose(talus.Model.from_tree(tree), talus.simulate(machine, duration_s=60, rate_hz=250, encoder_bits=17))
    assert found.verdict["effect"] == hidden and found.verdict["probability"] > 0.9 and len(found.effects) == 1
