"""What the torques show that does not come back with the motion and is no noise of a sensor: no model of the joint can explain it."""

import numpy as np

from . import noise


def excess(dataset, residuals):
    """{kind: chi-square of it} of the torques, beside what a fit leaves (`residuals`): what stands at one frequency or comes now and
    then (`dataset.irregular`), and what is still there later."""
    return {kind: max(dataset.irregular[kind], _lasting(dataset, residuals, kind)) * dataset.freedom(kind)
            for kind in dataset.kinds if kind[0] == "T"}  # fmt: skip


def _lasting(dataset, residuals, kind):
    """Power, over that of the noise, of what lasts: a torque that wanders, or a friction or a torque constant that does."""
    share = max(_share(dataset, residuals, kind, lag_s, view) for lag_s in noise.LASTING_S for view in range(VIEWS))
    return share / (1 - share)


def _share(dataset, residuals, kind, lag_s, view):
    found = []
    for channel in (c for c in dataset.channels if c.kind == kind):
        pairs = same_states(dataset, channel)
        if pairs is None:
            continue
        lag = max(1, round(lag_s / dataset.processed_recordings[channel.record].step_s))
        sign = directions(dataset, channel)[view]
        found.append(noise.differences(residuals.of[channel.record, kind], dataset.mask(channel), pairs, lag, sign))
    return noise.lasting_share(found) if found else 0.0


VIEWS = 3


def directions(dataset, channel):
    """Directions of what may wander, at every instant of the grid: a torque's own, friction's, the drive's."""
    return np.ones(len(channel.values)), of_motion(dataset, channel), np.sign(channel.values)


def of_motion(dataset, channel):
    """Direction in which the joint of a torque slips, at every instant of the grid."""
    processed, joint = dataset.processed_recordings[channel.record], int(channel.kind[1])
    return np.sign(processed.resample(processed.slip[joint]))


def same_states(dataset, channel):
    """Two arrays of rows of the grid: a period apart, else where nearly the same state comes back; None where it does not."""
    period_s = dataset.periods_s[channel.record]
    if period_s is None:
        return dataset.near_pairs(channel)
    lag = round(period_s / dataset.processed_recordings[channel.record].step_s)
    rows = np.arange(len(channel.values) - lag)
    return rows, rows + lag
