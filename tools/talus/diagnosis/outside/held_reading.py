"""A current or torque sensor that hangs: it shows its last reading for a while, now and then."""

import numpy as np

from .. import noise
from .law import entry, of

ONE_STEP = 1.5  # of the sensor, rounded: what leaps farther has left one out
NEXT = 3  # readings after a run, in which it must: the first one may be near by chance
BY_CHANCE = 1e-3  # runs of equal readings in a recording, that noise and the sensor's step make, of those that count


def held(x):
    """[(first row, last row)] of readings that stay the same for longer than chance has it: each one is the one before it by chance as
    often as one that follows a change is. Where they go on they have more than one of the sensor's steps to catch up: a torque that
    hardly changes stays within a step for as long."""
    same, step = np.diff(x) == 0, noise.finest_step(x)
    changed = ~same[:-1]
    often = same[1:][changed].mean() if changed.any() else 1.0
    ends = np.diff(np.concatenate([[False], same, [False]]).astype(int))
    begins, lasts = np.flatnonzero(ends == 1), np.flatnonzero(ends == -1)
    leaps = lambda e: np.abs(x[e + 1:e + 1 + NEXT] - x[e]).max(initial=0.0) > ONE_STEP * step
    return [(int(b), int(e)) for b, e in zip(begins, lasts) if often ** (e - b) * len(x) < BY_CHANCE and leaps(e)]


def late(terms, joint):
    """What the held readings differ by from the torque that they should show: all that these rows leave."""
    torque, out = terms.joint_Nm[joint], np.zeros((1, len(terms.t_s)))
    reading = terms.dataset.raw(terms.record, f"T{joint}")
    for first, last in terms.once(("held", joint), lambda: held(reading)):
        rows = slice(first + 1, last + 1)
        out[0, rows] = reading[first] * terms.ratio[joint, rows] - torque[rows]
    return out


ENTRIES = [entry("held_reading", "a current or torque reading that hangs now and then", of("held_reading", late, strengths=("share",)))]
