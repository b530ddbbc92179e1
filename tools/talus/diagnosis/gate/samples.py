"""Faults of single columns: spikes, wrapped angles, sensors that stand still, samples that repeat, currents at their limit."""

import numpy as np

from .finding import Finding

SPIKE_DEVIATIONS = 60.0  # of what neighbours leave, by the median: hardly any motion's own
SPIKE_RANGE_SHARE = 0.03  # of the column's range: smaller ones the low-pass bears
OUTSIDE_SHARE = 0.5  # of the range, by which a grave spike leaves it
MOST_SPIKES = 0.02  # of the rows: more are noise
TURNS = {"a turn in radians": 2 * np.pi, "half a turn in radians": np.pi, "a turn in degrees": 360.0}
TURN_TOLERANCE = 0.05
WRAPS_RANGE = 0.8  # of the column's range, that a wrapped angle jumps by at the least
STUCK_S, STUCK_ROWS = 0.3, 25
STUCK_JUMP_SHARE = 0.05  # of the range, by which a sensor that stood must jump when it lives again
HELD_SHARE = 0.45  # of all rows repeat the one before, while the column is fine elsewhere
SATURATED_SHARE, GRAVE_SATURATED_SHARE = 0.01, 0.2
SATURATED_RUN = 4


def is_angle(column):
    return column.endswith("_rad") or column == "slider_m"


def is_effort(column):
    return column.endswith(("_current_A", "_torque_Nm", "_force_N"))


def sample_findings(name, recording):
    """Findings of one recording's columns, each by itself."""
    for column, x in recording.columns.items():
        if is_angle(column):
            yield from _angle(name, recording, column, x)
        if is_effort(column):
            yield from _effort(name, recording, column, x)


def _angle(name, recording, column, x):
    wrapped = list(_wrapped(name, column, x))
    yield from wrapped
    if not wrapped:
        yield from _spikes(name, recording, column, x)
        yield from _stuck(name, recording, column, x)


def _effort(name, recording, column, x):
    yield from _spikes(name, recording, column, x)
    yield from _stuck(name, recording, column, x)
    yield from _saturated(name, column, x)


def _off_neighbours(t, x):
    """What each inner sample differs from the straight line between its neighbours, at their true times."""
    share = (t[1:-1] - t[:-2]) / (t[2:] - t[:-2])
    return x[1:-1] - (x[:-2] + share * (x[2:] - x[:-2]))


def _spikes(name, recording, column, x):
    """Single samples far off both neighbours, which lie close together."""
    t = recording.t
    off = _off_neighbours(t, x)
    usual = 1.4826 * np.median(np.abs(off)) + 1e-12 * np.ptp(x)
    inner = np.quantile(x, (0.005, 0.995))
    least = max(SPIKE_DEVIATIONS * usual, SPIKE_RANGE_SHARE * (inner[1] - inner[0]), 4 * np.quantile(np.abs(off), 0.995))
    together = np.abs(x[2:] - x[:-2]) < 0.5 * np.abs(off)  # the neighbours agree: no step
    found = np.flatnonzero((np.abs(off) > least) & together) + 1
    trimmed = recording.score.trim_s  # the ends are not used
    found = found[(t[found] > t[0] + trimmed) & (t[found] < t[-1] - trimmed)]
    if recording.valid is not None:
        found = found[np.minimum.reduce([recording.valid[found + d] for d in (-1, 0, 1)]) > 0]
    if 0 < len(found) < MOST_SPIKES * len(x):
        k = found[np.argmax(np.abs(off[found - 1]))]
        outside = max(x[k] - inner[1], inner[0] - x[k]) > OUTSIDE_SHARE * (inner[1] - inner[0])
        yield Finding("spike", bool(is_angle(column) and outside), column,
                      f"{name}: {len(found)} sample{'s' * (len(found) > 1)} far off the neighbours, the worst {x[k]:.4g} at "
                      f"{t[k]:.4g} s between {x[k - 1]:.4g} and {x[k + 1]:.4g}",
                      "set `valid` to 0 around these rows, and look for what disturbs the sensor")  # fmt: skip


def _wrapped(name, column, x):
    """Jumps that stay, all of one size: that of a turn, of what was counted, or of the whole range."""
    steps = np.diff(x)
    usual = np.quantile(np.abs(steps), 0.8) + 1e-12
    jumps = np.flatnonzero(np.abs(steps) > max(4 * usual, WRAPS_RANGE * np.ptp(x)))
    jumps = [k for k in jumps if not (k + 1 < len(steps) and abs(steps[k] + steps[k + 1]) < 0.5 * abs(steps[k]))
             and not (k > 0 and abs(steps[k] + steps[k - 1]) < 0.5 * abs(steps[k]))]  # fmt: skip
    if not jumps:
        return
    sizes, size = np.abs(steps[jumps]), float(np.ptp(x))
    turn = next((word for word, value in TURNS.items() if abs(size / value - 1) < TURN_TOLERANCE), None)
    if turn or (len(jumps) >= 2 and np.ptp(sizes) < 0.2 * size):
        yield Finding("wrapped", True, column, f"{name}: {len(jumps)} jump{'s' * (len(jumps) > 1)} over {size:.4g}"
                      f"{f', {turn}' if turn else ''}", "unwrap the angle: add a turn wherever it jumps back by one")  # fmt: skip


def _runs(same):
    """(begin, end) of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], same.astype(int), [0]])))
    return edges.reshape(-1, 2)


def _stuck(name, recording, column, x):
    """A sensor that shows one value to the last digit and then jumps, or holds each sample for several rows."""
    same = np.diff(x) == 0
    if same.all():
        unpowered = x[0] == 0.0 and "joint_load_Nm" in recording.columns  # turned from outside, beside a sensor
        if is_effort(column) and not unpowered:
            yield Finding("stuck", True, column, f"{name}: always {x[0]:g}", "check how this column is read")
        return
    least = max(STUCK_ROWS, STUCK_S / recording.step_s)
    inner = np.ptp(np.quantile(x, (0.01, 0.99))) + 1e-300
    usual = np.quantile(np.abs(np.diff(x)[~same]), 0.9)
    for begin, end in _runs(same):
        after = abs(x[end + 1] - x[end]) if end + 1 < len(x) else 0.0
        lasting = end - begin >= least and x[begin] != 0.0  # a drive that is off shows 0
        if lasting and (after > max(STUCK_JUMP_SHARE * inner, 5 * usual) or is_effort(column) and _is_noisy(x, same)):
            yield Finding("stuck", True, column, f"{name}: {x[begin]:.6g} to the last digit from {recording.t[begin]:.4g} to "
                          f"{recording.t[end]:.4g} s, then {x[min(end + 1, len(x) - 1)]:.6g}",
                          "set `valid` to 0 where the sensor does not answer")  # fmt: skip
            return
    runs = np.diff(_runs(same), axis=1)
    if is_effort(column) and same.mean() > HELD_SHARE and len(runs) and np.quantile(runs, 0.9) < least and _fine(x, same):
        yield Finding("stuck", False, column, f"{name}: {100 * same.mean():.0f} % of the rows repeat the one before",
                      "the column is sampled more slowly than the others: record it at its own rate, or all at one")  # fmt: skip


def _is_noisy(x, same):
    """Does the column change nearly always?"""
    return same.mean() < 0.5 and _fine(x, same)


def _fine(x, same):
    """Is its resolution much finer than its range, so that repeats are no quantisation?"""
    steps = np.abs(np.diff(x)[~same])
    return np.min(steps) < 1e-3 * (np.ptp(x) + 1e-300) and len(np.unique(steps)) > 50


def _lasting(same):
    """Rows in runs of SATURATED_RUN and more."""
    lengths = np.diff(_runs(same), axis=1)
    return float(lengths[lengths >= SATURATED_RUN].sum())


def _saturated(name, column, x):
    """Runs at exactly the largest or smallest value, where others hardly last: no current that was asked to be constant."""
    at_limit = (x == x.max()) | (x == x.min())
    share = _lasting(at_limit) / len(x)
    elsewhere = _lasting(np.concatenate([[False], np.diff(x) == 0]) & ~at_limit) / len(x)
    if share > SATURATED_SHARE and elsewhere < 0.2 * share and np.ptp(x) > 0.5 * np.abs(x).max():
        yield Finding("saturated", share > GRAVE_SATURATED_SHARE, column,
                      f"{name}: {100 * share:.0f} % of the rows stand at exactly {x.max():.4g} or {x.min():.4g}",
                      "raise the current limit or move more gently: what lies beyond the limit was not measured")  # fmt: skip
