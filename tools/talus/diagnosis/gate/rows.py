"""Rows that stand twice: in one recording, or in two."""

import numpy as np

from .finding import Finding
from .samples import is_angle

WINDOW = 12  # rows in a row that must be the same to the last digit
DOUBLED_SHARE, REPEATED_ROWS = 0.1, 100
DISTINCT_SHARE = 0.3  # of all rows: fewer, and the columns are too coarse for equal rows to say anything
MIX = 0x9E3779B97F4A7C15  # odd: no bit of a product is lost
MOVING_STEPS = 4  # of the encoder from row to row: faster, two equal rows are one read twice


def _windows(recording):
    """A number for each run of WINDOW rows; None for those in which hardly anything changes."""
    each, moves = np.zeros(len(recording.t), np.uint64), np.zeros(len(recording.t) - 1, bool)
    for number, (name, x) in enumerate(sorted(recording.columns.items()), 1):
        if name not in ("time_s", "valid"):
            bits = (x + 0.0).view(np.uint64)  # + 0.0: one zero
            each += (bits ^ (bits >> np.uint64(29))) * np.uint64(number * MIX % 2**64)
            moves |= np.diff(x) != 0
    out = np.zeros(len(each) - WINDOW + 1, np.uint64)
    for k in range(WINDOW):
        out = out * np.uint64(0x100000001B3) + each[k:k + len(out)]
    if len(np.unique(each)) < DISTINCT_SHARE * len(each):
        return out, np.zeros(len(out), bool)
    changes = np.concatenate([[0], np.cumsum(moves)])
    return out, changes[WINDOW - 1:] - changes[:-WINDOW + 1] >= WINDOW - 1


def row_findings(names, recordings):
    """Findings of rows that stand twice."""
    windows = [_windows(r) if len(r.t) > 2 * WINDOW else (np.empty(0, np.uint64), np.empty(0, bool)) for r in recordings]
    for name, recording, (number, busy) in zip(names, recordings, windows, strict=True):
        yield from _doubled(name, recording)
        own = number[busy]
        repeated = len(own) - len(np.unique(own))
        if repeated > REPEATED_ROWS:
            yield Finding("repeated_rows", True, "", f"{name}: {repeated} rows stand in the file a second time, to the last digit",
                          "take out what was copied twice")  # fmt: skip
    for i in range(len(recordings)):
        for k in range(i):
            common = len(np.intersect1d(windows[i][0][windows[i][1]], windows[k][0][windows[k][1]]))
            if common > REPEATED_ROWS:
                yield Finding("overlap", True, "", f"{names[k]} and {names[i]} have {common} rows in common, to the last digit",
                              "give each stretch of time once: held-out data would be known already")  # fmt: skip


def _doubled(name, recording):
    """Rows that repeat the one before while the joint moves by several steps of its encoder."""
    columns = [x for column, x in recording.columns.items() if column not in ("time_s", "valid")]
    angles = [x for column, x in recording.columns.items() if is_angle(column)]
    if not angles:
        return
    fast = np.zeros(len(recording.t) - 1, bool)
    for x in angles:
        step = np.abs(np.diff(x))
        finest = np.min(step[step > 0], initial=np.inf)
        speed = np.abs(np.convolve(np.diff(x), np.full(5, 0.2), "same"))
        fast |= speed > MOVING_STEPS * max(finest, 1e-9 * np.ptp(x)) if np.isfinite(finest) else False
    same = np.all([np.diff(x) == 0 for x in columns], axis=0)
    share = float((same & fast).sum()) / max(int(fast.sum()), 1)
    if fast.sum() > REPEATED_ROWS and share > DOUBLED_SHARE:
        yield Finding("repeated_rows", True, "", f"{name}: {100 * share:.0f} % of the rows in motion repeat the one before with a later time",
                      "write each sample once")  # fmt: skip
