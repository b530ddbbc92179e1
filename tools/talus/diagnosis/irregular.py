"""What the torques show that does not come back with the motion and is no noise of a sensor: no model of the joint can explain it."""

import numpy as np

from . import noise


def excess(dataset, residuals):
    """{kind: chi-square of it} of the torques, beside what a fit leaves (`residuals`): what stands at one frequency or comes now and
    then (`dataset.irregular`), and what is still there a second later."""
    return {kind: max(dataset.irregular[kind], _lasting(dataset, residuals, kind)) * dataset.freedom(kind)
            for kind in dataset.kinds if kind[0] == "T"}  # fmt: skip


def _lasting(dataset, residuals, kind):
    """Power, over that of the noise, of what lasts."""
    found = []
    for channel in (c for c in dataset.channels if c.kind == kind):
        step_s, pairs = dataset.processed_recordings[channel.record].step_s, same_states(dataset, channel)
        if pairs is not None:
            lag = max(1, round(noise.LASTING_S / step_s))
            found.append(noise.differences(residuals.of[channel.record, kind], dataset.mask(channel), pairs, lag))
    share = noise.lasting_share(found) if found else 0.0
    return share / (1 - share)


def same_states(dataset, channel):
    """Two arrays of rows of the grid: a period apart, else where nearly the same state comes back; None where it does not."""
    period_s = dataset.periods_s[channel.record]
    if period_s is None:
        return dataset.near_pairs(channel)
    lag = round(period_s / dataset.processed_recordings[channel.record].step_s)
    rows = np.arange(len(channel.values) - lag)
    return rows, rows + lag
