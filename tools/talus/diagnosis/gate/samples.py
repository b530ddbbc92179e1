"""Faults of single columns: spikes, wrapped angles, sensors that stand still, samples that repeat, currents at their limit."""

import numpy as np

from .finding import Finding

SPIKE_DEVIATIONS = 60.0  # of what neighbours leave, by the median: hardly any motion's own
NOISE_DEVIATIONS = 12.0  # the same of noise: no row of an hour's
SPIKE_RANGE_SHARE = 0.03  # of the column's range: smaller ones the low-pass bears
OUTSIDE_SHARE = 0.5  # of the range, by which a grave spike leaves it
SPIKE_ROWS = 4  # a jump that comes back within half of these was a spike
MOST_SPIKES = 0.02  # of the rows: more are noise
TURNS = {"a turn in radians": 2 * np.pi, "half a turn in radians": np.pi, "a turn in degrees": 360.0}
TURN_TOLERANCE = 0.05
LOST_STEPS = 1.5  # from row to row: rows between them were lost
WRAPS_RANGE = 0.8  # of the column's range, that a wrapped angle jumps by at the least
FEWEST_STEPS = 5  # of a column that is compared with another: with fewer, rounding alone makes any slope
STUCK_S, STUCK_ROWS = 0.3, 25
STUCK_JUMP_SHARE = 0.05  # of the range, by which a sensor that stood must jump when it lives again
HELD_SHARE = 0.45  # of all rows repeat the one before, while the column is fine elsewhere
NOISY_REPEATS = 0.3  # of all rows: 25 in a row come once in 10^13
FEWEST_CHANGES, EVEN_SHARE = 50, 0.9
SATURATED_SHARE, GRAVE_SATURATED_SHARE = 0.01, 0.2
SATURATED_RUN = 4


def is_angle(column):
    return column.endswith("_rad") or column == "slider_m"


def is_effort(column):
    return column.endswith(("_current_A", "_torque_Nm", "_force_N"))


def finest_step(x):
    """The smallest step of a column that moves."""
    steps = np.abs(np.diff(x))
    return np.min(steps[steps > 1e-9 * np.ptp(x)], initial=np.inf)


def shows(x):
    """Does a column move by steps enough to be compared with another?"""
    return np.ptp(x) > FEWEST_STEPS * finest_step(x)


def sample_findings(name, recording):
    """Findings of one recording's columns, each by itself."""
    for column, x in recording.columns.items():
        if is_angle(column):
            yield from _angle(name, recording, column, x)
        if is_effort(column):
            yield from _effort(name, recording, column, x)


def _angle(name, recording, column, x):
    wrapped = list(_wrapped(name, recording, column, x))
    yield from wrapped
    if not wrapped:
        yield from _spikes(name, recording, column, x)
        yield from _stuck(name, recording, column, x)


def _effort(name, recording, column, x):
    yield from _spikes(name, recording, column, x)
    saturated = list(_saturated(name, column, x))
    yield from saturated
    yield from _stuck(name, recording, column, x, at_limit=bool(saturated))


def _off_neighbours(t, x):
    """What each inner sample differs from the straight line between its neighbours, at their true times."""
    share = (t[1:-1] - t[:-2]) / (t[2:] - t[:-2])
    return x[1:-1] - (x[:-2] + share * (x[2:] - x[:-2]))


def spike_rows(recording, x):
    """Rows of single samples far off both neighbours, which lie close together."""
    t = recording.t
    off = _off_neighbours(t, x)
    usual = 1.4826 * np.median(np.abs(off)) + 1e-12 * np.ptp(x)
    inner = np.quantile(x, (0.005, 0.995))
    least = max(SPIKE_DEVIATIONS * usual, SPIKE_RANGE_SHARE * (inner[1] - inner[0]))
    least = min(least, max(inner[1] - inner[0], NOISE_DEVIATIONS * usual))  # the range is surely left
    together = np.abs(x[2:] - x[:-2]) < 0.5 * np.abs(off)  # the neighbours agree: no step
    apart = (np.abs(off) > least) & together
    others = np.abs(off[~_beside(apart)])
    found = np.flatnonzero(apart & (np.abs(off) > 4 * np.quantile(others, 0.995) if len(others) else False)) + 1
    trimmed = recording.score.trim_s  # the ends are not used
    found = found[(t[found] > t[0] + trimmed) & (t[found] < t[-1] - trimmed)]
    if recording.valid is not None:
        found = found[np.minimum.reduce([recording.valid[found + d] for d in (-1, 0, 1)]) > 0]
    return found[np.argsort(-np.abs(off[found - 1]))] if len(found) < MOST_SPIKES * len(x) else found[:0]


def _spikes(name, recording, column, x):
    """The finding of spikes."""
    found, inner, t = spike_rows(recording, x), np.quantile(x, (0.005, 0.995)), recording.t
    if len(found):
        k = found[0]
        outside = max(x[k] - inner[1], inner[0] - x[k]) > OUTSIDE_SHARE * (inner[1] - inner[0])
        yield Finding("spike", bool(is_angle(column) and outside), column,
                      f"{name}: {len(found)} sample{'s' * (len(found) > 1)} far off the neighbours, the worst {x[k]:.4g} at "
                      f"{t[k]:.4g} s between {x[k - 1]:.4g} and {x[k + 1]:.4g}",
                      "set `valid` to 0 around these rows, and look for what disturbs the sensor")  # fmt: skip


def without_spikes(recording):
    """The recording with `valid` 0 where a column has spikes."""
    bad = np.zeros(len(recording.t), bool)
    for column, x in recording.columns.items():
        if is_angle(column) or is_effort(column):
            bad[spike_rows(recording, x)] = True
    if not bad.any():
        return recording
    valid = np.ones(len(bad)) if recording.valid is None else recording.valid
    out = recording.with_columns({**recording.columns, "valid": np.where(_beside(bad), 0.0, valid)})
    out.origin = recording.origin
    return out


def _beside(rows):
    """These rows and their neighbours."""
    return rows | np.concatenate([rows[1:], [False]]) | np.concatenate([[False], rows[:-1]])


def _wrapped(name, recording, column, x):
    """Jumps that stay, all of one size: that of a turn, of what was counted, or of the whole range. A change of one step of the
    encoder is none, nor is one while rows were lost."""
    steps = np.diff(x)
    usual = np.quantile(np.abs(steps), 0.8) + 1e-12
    jumped = np.abs(steps) > max(4 * usual, WRAPS_RANGE * np.ptp(x), 4 * finest_step(x))
    jumps = np.flatnonzero(jumped & (np.diff(recording.t) < LOST_STEPS * recording.step_s))
    jumps = [k for k in jumps if _stays(x, k)]
    if not jumps:
        return
    sizes, size = np.abs(steps[jumps]), float(np.ptp(x))
    turn = next((word for word, value in TURNS.items() if abs(size / value - 1) < TURN_TOLERANCE), None)
    if turn or (len(jumps) >= 2 and np.ptp(sizes) < 0.2 * size):
        yield Finding("wrapped", True, column, f"{name}: {len(jumps)} jump{'s' * (len(jumps) > 1)} over {size:.4g}"
                      f"{f', {turn}' if turn else ''}", "unwrap the angle: add a turn wherever it jumps back by one")  # fmt: skip


def _stays(x, k):
    """Is what jumps behind row k a while where it was before, and afterwards where it went?"""
    before, after = np.median(x[max(0, k - SPIKE_ROWS):k + 1]), np.median(x[k + 1:k + 2 + SPIKE_ROWS])
    return abs(after - before) > 0.5 * abs(x[k + 1] - x[k])


def runs_of(same):
    """(begin, end) of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], same.astype(int), [0]])))
    return edges.reshape(-1, 2)


def _stuck(name, recording, column, x, at_limit=False):
    """A sensor that shows one value to the last digit and then jumps, or holds each sample for several rows. What is `at_limit` of
    the drive stands there for another reason."""
    same = np.diff(x) == 0
    if same.all():
        unpowered = x[0] == 0.0 and "joint_load_Nm" in recording.columns  # turned from outside, beside a sensor
        if is_effort(column) and not unpowered:
            yield Finding("stuck", True, column, f"{name}: always {x[0]:g}", "check how this column is read")
        return
    least, runs = max(STUCK_ROWS, STUCK_S / recording.step_s), runs_of(same)
    for begin, end in runs[runs[:, 1] - runs[:, 0] >= least]:
        off = x[begin] == 0.0 or (at_limit and x[begin] in (x.min(), x.max()))  # a drive that is off shows 0
        if not off and (_revives(recording, x, end, same) or is_effort(column) and _is_noisy(same, begin, end)):
            yield Finding("stuck", True, column, f"{name}: {x[begin]:.6g} to the last digit from {recording.t[begin]:.4g} to "
                          f"{recording.t[end]:.4g} s, then {x[min(end + 1, len(x) - 1)]:.6g}",
                          "set `valid` to 0 where the sensor does not answer")  # fmt: skip
            return
    if is_effort(column) and not at_limit and _is_held(x, same, least):
        yield Finding("stuck", False, column, f"{name}: {100 * same.mean():.0f} % of the rows repeat the one before",
                      "the column is sampled more slowly than the others: record it at its own rate, or all at one")  # fmt: skip


def _revives(recording, x, end, same):
    """Does a column that stood up to row `end` jump then, farther than it moves by itself, and stay away? What moved while rows
    were lost does not count, nor does a spike."""
    after, usual = x[end + 1:end + 2 + SPIKE_ROWS // 2], np.quantile(np.abs(np.diff(x)[~same]), 0.9)
    if len(after) == 0 or recording.t[end + 1] - recording.t[end] > LOST_STEPS * recording.step_s:
        return False
    inner = np.ptp(np.quantile(x, (0.01, 0.99)))
    return np.min(np.abs(after - x[end])) > max(STUCK_JUMP_SHARE * inner, 5 * usual)


def _is_held(x, same, least):
    """Are most rows repeats, of a column that is fine elsewhere or changes only at each so many-th row?"""
    runs = np.diff(runs_of(same), axis=1)
    if len(runs) == 0 or same.mean() <= HELD_SHARE or np.quantile(runs, 0.9) >= least:
        return False
    return _fine(x, same) or changes_evenly(same)


def changes_evenly(same):
    """Do changes come after two rows, or three or more, and whole multiples of these? Noise keeps no time."""
    between = np.diff(np.flatnonzero(~same))
    if len(between) < FEWEST_CHANGES:
        return False
    every = int(np.bincount(between).argmax())
    return every > 1 and np.mean(between % every == 0) > EVEN_SHARE


def _is_noisy(same, begin, end):
    """Does the column elsewhere change nearly always, so that it never stands so long by chance?"""
    return (same.sum() - (end - begin)) / max(len(same) - (end - begin), 1) < NOISY_REPEATS


def _fine(x, same):
    """Is its resolution much finer than its range, so that repeats are no quantisation?"""
    steps = np.abs(np.diff(x)[~same])
    return np.min(steps) < 1e-3 * (np.ptp(x) + 1e-300) and len(np.unique(steps)) > 50


def _lasting(same):
    """Rows in runs of SATURATED_RUN and more."""
    lengths = np.diff(runs_of(same), axis=1)
    return float(lengths[lengths >= SATURATED_RUN].sum())


def _saturated(name, column, x):
    """Runs at exactly the largest or smallest value, where others hardly last: no current that was asked to be constant. A drive
    that is off shows 0."""
    at_limit = ((x == x.max()) | (x == x.min())) & (x != 0.0)
    share = _lasting(at_limit) / len(x)
    elsewhere = _lasting(np.concatenate([[False], np.diff(x) == 0]) & ~at_limit & (x != 0.0)) / len(x)
    if share > SATURATED_SHARE and elsewhere < 0.2 * share and np.ptp(x) > 0.5 * np.abs(x).max():
        limits = " or ".join(f"{limit:.4g}" for limit in (x.max(), x.min()) if limit)
        yield Finding("saturated", share > GRAVE_SATURATED_SHARE, column, f"{name}: {100 * share:.0f} % of the rows stand at exactly {limits}",
                      "raise the current limit or move more gently: what lies beyond the limit was not measured")  # fmt: skip
