"""What the torques show that does not repeat with the motion and is no noise of a sensor: no model of the joint can explain it."""

import numpy as np

from . import noise


def excess(dataset, residuals):
    """{kind: chi-square of it} of the torques, beside what a fit leaves (`residuals`): what stands at one frequency or comes now and
    then (`dataset.irregular`), and what is still there later."""
    return {kind: max(dataset.irregular[kind], _lasting(dataset, residuals, kind)) * dataset.freedom(kind)
            for kind in dataset.kinds if kind[0] == "T"}  # fmt: skip


def shares(search):
    """`irregular` of the report: at which joints it is, and its share of all that the plain model leaves above the noise, largest first. A lower
    bound: what acts so seldom that it does not raise the noise of the recording counts as the rest of the gap."""
    apart = search.irregular(search.plain)
    whole = sum(max(x, 0.0) for x in search.held_out_excess([]).values()) + sum(apart.values())
    found = [{"joint": search.dataset.model.joints[int(kind[1])], "share": x / whole} for kind, x in apart.items() if x > 0]
    return sorted(found, key=lambda one: -one["share"])


def _lasting(dataset, residuals, kind):
    """Power, over that of the noise, of what lasts: a torque that wanders, or a friction or a torque constant that does. What turns with the
    motion or the drive is known sooner, for no noise of a sensor does."""
    looks = [(lag_s, view, False) for lag_s in noise.LASTING_S for view in range(VIEWS)]
    looks += [(noise.TURNED_S, view, True) for view in range(1, VIEWS)]
    share = max(_share(dataset, residuals, kind, *look) for look in looks)
    return share / (1 - share)


def _share(dataset, residuals, kind, lag_s, view, turned):
    found = []
    for channel in (c for c in dataset.channels if c.kind == kind):
        pairs, processed = same_states(dataset, channel), dataset.processed_recordings[channel.record]
        if pairs is None:
            continue
        least_s = noise.TURNED_PERIODS / processed.recording.score.lowpass_hz  # sooner, filtered noise swings by itself
        lag = max(1, round((max(lag_s, least_s) if turned else lag_s) / processed.step_s))
        sign = directions(dataset, channel)[view]
        found.append(noise.differences(residuals.of[channel.record, kind], dataset.mask(channel), pairs, lag, sign, turned))
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
