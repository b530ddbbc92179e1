"""Counts to angles: the relative encoder of a motor is unrolled and zeroed by the absolute one at its joint."""

import numpy as np

from .refused import Refused

TURN = 2 * np.pi


def joint_angle(counts, bus):
    """An absolute encoder's angle [rad]: 0 at `zero_count`, within half a turn of it."""
    per_turn = bus["counts_per_turn"]
    offset = counts - bus["zero_count"]
    return bus["sign"] * TURN * (offset - per_turn * np.floor(offset / per_turn + 0.5)) / per_turn


def motor_angle(counts, span, expected_rad, bus):
    """(angle [rad], its zero [counts], spread [counts]) of a counter that wraps at `span`, from where the joint's
    encoder and the transmission say that the motor is. No sample needs its neighbours: a gap costs nothing."""
    expected = bus["sign"] * expected_rad / TURN * bus["counts_per_turn"]
    off = np.exp(2j * np.pi * (counts - expected) / span)
    near = np.angle(off.mean()) * span / TURN
    error = counts - expected - near
    error -= span * np.floor(error / span + 0.5)
    middle = mean_over_places(np.rint(expected + near + error).astype(np.int64), error)
    angle = bus["sign"] * TURN * (expected + error - middle) / bus["counts_per_turn"]
    return angle, float((near + middle) % span), float(error.std())


def mean_over_places(place, error):
    """The mean in which each place counts once, however long the joint stood there: the absolute encoder's
    rounding, coarse after the transmission, is another at each place and averages out, but not at one."""
    _, which, times = np.unique(place, return_inverse=True, return_counts=True)
    return float(np.mean(np.bincount(which, error) / times))


def unrolled_angle(counts, span, bus):
    """Without an absolute encoder: from the first sample on, the shorter way from each to the next."""
    step = np.diff(counts.astype(np.int64))
    step = (step + span // 2) % span - span // 2
    return bus["sign"] * TURN * np.append(0, np.cumsum(step)) / bus["counts_per_turn"]


def check_spread(name, spread, span):
    """Two encoders of one joint that say the same differ by far less than the counter's span."""
    if spread > span / 8:
        raise Refused(2, f"{name}: motor and joint encoder contradict each other by {spread:.0f} counts (standard "
                         "deviation); counts_per_turn, sign or zero_count of bus: in the model file, or its "
                         "transmission, are not this bench's")  # fmt: skip
