"""Has an effect the same size everywhere? A law has: under small torques and large ones, slow and fast, either way, on either side of the
range, early and late. What an effect does in the place of another cause has another size in each.

Rows are halved by each of these quantities, so that the effect does as much in either half. With r what a fit leaves, C of the effect's
columns what no other column of the fit does, and s its strengths, these are off in a half by d, and the effect is uneven by u:

    d = argmin |r - C d|,    u = max (|C d| - 2 |r| / sqrt(n)) / |C s|

over halves of n rows: the noise alone moves them so far in one of twenty. Regressions over two halves are compared since Chow (1960); here
all other parameters stay those of the whole. A true law in an approximate form is off, too, by up to 0.3.
"""

import numpy as np

from .thresholds import DEVIATIONS, HALF, PART

LEAST_HALF = 0.15  # of the effect's squares: where no row lies between, halves cannot be made
SINGULAR = 1e-9


def is_uneven(search, fit):
    """Has the last effect of a fit another size somewhere, by more than half of it?"""
    return max(by_half(search, fit), default=0.0) > HALF


def by_half(search, fit):
    """How far off the last effect's size is, of that size, in either half of each quantity; of the torques that show a PART of it."""
    gram, columns, strengths = search.gram, search.columns(fit.chosen), np.array(fit.strengths[-1])
    rows = gram.gathered(columns)
    left, shown = gram.left(gram.fold_strengths(columns)[-1], rows), alone(gram.plain, rows, len(strengths))
    squares = [np.sum((strengths @ own) ** 2) for own in shown]
    for layout, rest, own, much in zip(gram.layouts, left, shown, squares, strict=True):
        if layout.kind[0] == "T" and much > PART * sum(squares):
            for half in _halves(search.dataset, layout, strengths @ own):
                yield _off(rest[half], own[:, half], strengths)


def alone(plain, rows, count):
    """What the last columns of a fit do that no other one does, one matrix a layout."""
    every = np.concatenate([np.concatenate([base[:-1], own]) for base, own in zip(plain, rows, strict=True)], axis=1)
    others, last = every[:-count], every[-count:]
    scale = np.linalg.norm(others, axis=1)
    others = others[scale > 0] / scale[scale > 0][:, None]
    found = last - np.linalg.lstsq(others.T, last.T, rcond=SINGULAR)[0].T @ others
    return np.split(found, np.cumsum([base.shape[1] for base in plain])[:-1], axis=1)


def _off(left, columns, strengths):
    change = np.linalg.lstsq(columns.T, left, rcond=SINGULAR)[0]
    by_chance = DEVIATIONS * np.sqrt(np.mean(left**2))
    return float((np.linalg.norm(change @ columns) - by_chance) / np.linalg.norm(strengths @ columns))


def _halves(dataset, layout, effect):
    """Rows of either half of each quantity, in which an effect's squares are as many."""
    for values in _quantities(dataset, layout):
        order = np.argsort(values, kind="stable")
        squares = np.cumsum(effect[order] ** 2)
        lower = values <= values[order[np.searchsorted(squares, 0.5 * squares[-1])]]
        if LEAST_HALF < np.sum(effect[lower] ** 2) / squares[-1] < 1.0 - LEAST_HALF:
            yield lower
            yield ~lower


def _quantities(dataset, layout):
    """What the rows of a joint are halved by: torque and speed with their signs and without, angle, time."""
    joint, every = int(layout.kind[1]), dataset.processed_recordings
    torque = layout.on_rows([processed.target[joint] for processed in every])
    speed = layout.on_rows([processed.resample(processed.v[joint]) for processed in every])
    angle = layout.on_rows([processed.resample(processed.q[joint]) for processed in every])
    time = layout.on_rows([processed.grid_t_s - processed.grid_t_s[0] for processed in every])
    return torque, np.abs(torque), speed, np.abs(speed), angle, time
