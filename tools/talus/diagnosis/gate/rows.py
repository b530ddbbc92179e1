"""Rows that stand twice: in one recording, or in two."""

import numpy as np

from .finding import Finding
from .samples import changes_evenly, finest_step, is_angle, runs_of

EVENTS = 24  # rows in which something changes, in a row, that must be the same to the last digit, with the rows between them
DOUBLED_SHARE, REPEATED_ROWS = 0.1, 100
FEWEST_LEFT = 100  # rows, of which something can be said
MIX = 0x9E3779B97F4A7C15  # odd: no bit of a product is lost
MOVING_STEPS = 4  # of the encoder from row to row: faster, two equal rows are one read twice


def _columns(recording):
    """All but time and mask, by name."""
    return [x for name, x in sorted(recording.columns.items()) if name not in ("time_s", "valid")]


def _same(recording):
    """Where a row repeats the one before."""
    return np.all([np.diff(x) == 0 for x in _columns(recording)], axis=0)


def _events(recording):
    """Rows that differ from the one before."""
    return np.flatnonzero(np.concatenate([[True], ~_same(recording)]))


def _windows(recording):
    """A number for each run of EVENTS rows that differ from the one before, by their values and by how long they last."""
    events = _events(recording)
    if len(events) < 2 * EVENTS:
        return np.empty(0, np.uint64)
    each = np.diff(np.concatenate([events, [len(recording.t)]])).astype(np.uint64)
    for number, x in enumerate(_columns(recording), 1):
        bits = (x[events] + 0.0).view(np.uint64)  # + 0.0: one zero
        each += (bits ^ (bits >> np.uint64(29))) * np.uint64(number * MIX % 2**64)
    out = np.zeros(len(each) - EVENTS + 1, np.uint64)
    for k in range(EVENTS):
        out = out * np.uint64(0x100000001B3) + each[k:k + len(out)]
    return out


def _in_step(places, others):
    """(length, first of `places`) of the longest run of pairs of windows that follow each other in both recordings: what is equal
    by chance, in columns that hardly change, soon does not."""
    runs = runs_of((np.diff(others - places) == 0) & (np.diff(places) == 1))
    if len(runs) == 0:
        return 0, 0
    begin, end = max(runs, key=lambda run: run[1] - run[0])
    return int(end - begin), int(places[begin])


def without_copy(recording):
    """The recording without the rows that stand in it a second time: where these begin and end, every column jumps."""
    length, first = _repeated(_windows(recording))
    if length <= REPEATED_ROWS:
        return recording
    events = _events(recording)
    begin, end = max(first - 1, 0), min(first + length + EVENTS + 1, len(events) - 1)
    kept = np.ones(len(recording.t), bool)
    kept[events[begin]:len(kept) if end == len(events) - 1 else events[end]] = False
    return recording.with_columns({name: x[kept] for name, x in recording.columns.items()}) if kept.sum() > FEWEST_LEFT else recording


def _repeated(windows):
    """(count, first) of the windows of a recording that stood in it before."""
    _, first, which = np.unique(windows, return_index=True, return_inverse=True)
    again = np.flatnonzero(first[which] < np.arange(len(windows)))
    return _in_step(again, first[which][again])


def _common(one, other):
    """(count, first) of the windows that two recordings have in common."""
    known, first = np.unique(other, return_index=True)
    if len(known) == 0:
        return 0, 0
    at = np.minimum(np.searchsorted(known, one), len(known) - 1)
    found = np.flatnonzero(known[at] == one)
    return _in_step(found, first[at][found])


def row_findings(names, recordings):
    """Findings of rows that stand twice."""
    windows = [_windows(r) for r in recordings]
    for name, recording, own in zip(names, recordings, windows, strict=True):
        yield from _doubled(name, recording)
        repeated, _ = _repeated(own)
        if repeated > REPEATED_ROWS:
            yield Finding("repeated_rows", True, "", f"{name}: {repeated} rows stand in the file a second time, to the last digit",
                          "take out what was copied twice")  # fmt: skip
    for i in range(len(recordings)):
        for k in range(i):
            common, _ = _common(windows[i], windows[k])
            if common > REPEATED_ROWS:
                yield Finding("overlap", True, "", f"{names[k]} and {names[i]} have {common} rows in common, to the last digit",
                              "give each stretch of time once: held-out data would be known already")  # fmt: skip


def _doubled(name, recording):
    """Rows that repeat the one before: at each second row, or while the joint moves by several steps of its encoder."""
    same = _same(recording)
    evenly = changes_evenly(same)
    fast = _fast(recording)
    share = float(same.mean() if evenly else (same & fast).sum() / max(int(fast.sum()), 1))
    if evenly or (fast.sum() > REPEATED_ROWS and share > DOUBLED_SHARE):
        yield Finding("repeated_rows", True, "", f"{name}: {100 * share:.0f} % of the rows{'' if evenly else ' in motion'} repeat the "
                      "one before with a later time",
                      "write each sample once; columns that come at rates of their own belong in a file each, for talus-import")  # fmt: skip


def _fast(recording):
    """Where a joint moves by several steps of its encoder from row to row, over a few rows: not over lost ones."""
    fast, t = np.zeros(len(recording.t) - 1, bool), np.diff(recording.t)
    for x in (x for column, x in recording.columns.items() if is_angle(column)):
        step = np.where(t < 1.5 * recording.step_s, np.diff(x), 0.0)
        fast |= np.abs(np.convolve(step, np.full(5, 0.2), "same")) > MOVING_STEPS * finest_step(x)
    return fast
