"""Shapes of effects between the grid's: one value after the other, and all of them at once by Gauss and Newton, as
Levenberg and Marquardt damp it. Every step is judged on held-out blocks, as all fits are."""

import itertools

import numpy as np

from . import processors
from .gram import solve

REFINED_WITHIN = 2.5  # times the best excess on the grid; and of what reconstruction leaves, more than which is much
STEP_SHARES, FINE_SHARES = (0.5, 0.25, 0.12), (0.25, 0.12)  # of a shape's first step
MOST_ROUNDS = 2  # through all values with one step
LEAST_GAIN = 8.0  # chi-square: less is not worth another shape
GAIN_OF_ROUGH = 0.05  # nor is this share of what reconstruction leaves: shapes do not mend that
ROUGH_OF_SIGNAL = 0.007  # of the measured torque, that it may leave beside the tolerated excess
SLOPE_SHARE = 0.15  # of a shape's first step, over which slopes are taken: jolts make shorter ones rough
DAMPINGS = (0.003, 0.03, 0.3, 3.0)  # of the excess, that a step as long as the first one costs
MOST_STEPS = 5  # of Gauss and Newton
ROUGH_STARTS = 5  # of the grid's shapes, where valleys are many
ROUGH_WITHIN, ROUGH_ENDS = 1.5, 2  # times the best end's excess, and so many of them, to be followed further


def refined(search, fit, place):
    """The fit with one effect's shape moved downhill; while much is left, from others of the grid's shapes, too. A shape that cannot be
    moved is held against those that can in any case."""
    best, much = _newton(search, _stepwise(search, fit, place), place), REFINED_WITHIN * search.rough
    if fit.chosen[place] not in search.gram.candidates:
        return best
    if not fit.chosen[place].family:
        much = 0.0
    if best.excess > much:
        best = _from_valleys(search, best, _valleys(search, fit, place), place)
        for start in _other_starts(search, fit, place):
            if best.excess > much:
                best = min(best, _newton(search, _stepwise(search, start, place), place), key=_excess)
    return best


def _excess(fit):
    return fit.excess


def _is_better(search, found, fit):
    """Is a fit worth another shape, and physical, or at least what leads there if the old one is not?"""
    gain = fit.excess - found.excess
    physical = found.is_physical(looking=not fit.is_physical())
    return physical and gain > max(LEAST_GAIN, GAIN_OF_ROUGH * search.rough)


# ---- starts ------------------------------------------------------------------------


def _on_the_grid(search, fit, place, wanted, looking=False):
    """Fits with other shapes of the grid, the `wanted` families', best first."""
    old, others = fit.chosen[place], [*fit.chosen[:place], *fit.chosen[place + 1:]]
    shapes = [c for c in search.gram.candidates if c.key == old.key and c.family and wanted(c.family)]
    found = search.beside(others, shapes, looking) if shapes else []
    return [one.last_moved(place) for one in sorted(found, key=_excess)]


def _valleys(search, fit, place):
    """The best few shapes of the grid, where valleys are many, and of those elsewhere."""
    family = fit.chosen[place].family
    if not (family and family.rough):
        return []
    starts = _on_the_grid(search, fit, place, lambda family: True, looking=True)[:ROUGH_STARTS]
    return starts + [start for factors in family.elsewhere for start in _off_the_grid(search, fit, place, factors)]


def _off_the_grid(search, fit, place, factors):
    """The best few fits with the grid's shapes, each value times its factor."""
    key = fit.chosen[place].key
    families = [c.family for c in search.gram.candidates if c.key == key and c.family]
    shapes = [family.make(*(x * factor for x, factor in zip(family.values, factors, strict=True))) for family in families]
    search.gram.make(search.columns(shapes))
    found = sorted((_with(search, fit, place, shape) for shape in shapes), key=_excess)[:ROUGH_STARTS]
    search.gram.forget([*fit.chosen, *(c for one in found for c in one.chosen)])
    return found


def _other_starts(search, fit, place):
    """The best of each kind of shape that no way leads to from this one; none leads from one that cannot be moved."""
    family, best = fit.chosen[place].family, {}
    here = family.start if family else None
    for one in _on_the_grid(search, fit, place, lambda family: family.start != here):
        best.setdefault(one.chosen[place].family.start, one)
    return list(best.values())


def _from_valleys(search, best, starts, place):
    """The best of what is found from several starts, the nearest ends followed further."""
    if not starts:
        return best
    ends = [end for start in starts if (end := _newton(search, start, place)).is_physical()]
    ends = sorted([best, *ends], key=_excess)[:ROUGH_ENDS]
    near = [end for end in ends if end.excess < ROUGH_WITHIN * ends[0].excess]
    further = [_newton(search, _stepwise(search, end, place, FINE_SHARES), place) for end in near]
    return min([*ends, *further], key=_excess)


# ---- one value after the other -----------------------------------------------------


def _stepwise(search, fit, place, shares=STEP_SHARES):
    """One effect's shape moved one value after the other, with ever smaller steps."""
    done = None  # the step that moves nothing any more
    for share in (s for s in shares for _ in range(MOST_ROUNDS)):
        if share == done:
            continue
        before = fit
        for number in range(len(fit.chosen[place].family.directions) if fit.chosen[place].family else 0):
            fit = _moved(search, fit, place, number, share)
        done = share if fit is before else None
    search.gram.forget(fit.chosen)
    return fit


def _moved(search, fit, place, number, share):
    """One value of one effect's shape moved up or down, where that is better."""
    family = fit.chosen[place].family
    both = [other for side in (1, -1) if (other := family.beside(number, share, side)) is not None]
    if processors.are_free():  # the second one is in vain where the first is better
        search.gram.make(search.columns(both))
    for other in both:
        if _is_better(search, found := _with(search, fit, place, other), fit):
            return found
    return fit


def _with(search, fit, place, other):
    """The fit with another candidate at one place."""
    return search.fit([*fit.chosen[:place], other, *fit.chosen[place + 1:]])


# ---- all values at once ------------------------------------------------------------


def _newton(search, fit, place):
    """One effect's shape moved with all its values at once, if it has several."""
    family = fit.chosen[place].family
    for _ in range(MOST_STEPS if family and len(family.values) > 1 else 0):
        before, fit = fit, _stepped(search, fit, place)
        search.gram.forget(fit.chosen)
        if fit is before:
            break
    return fit


def _stepped(search, fit, place):
    """One step; with more damping as long as that makes it better."""
    best, shapes = fit, [fit.chosen[place].family.moved(moves) for moves in _moves(search, fit, place)]
    if processors.are_free():  # a better one is seldom found before the last
        search.gram.make(search.columns(shapes))
    for shape in shapes:
        found = _with(search, fit, place, shape)
        if _is_better(search, found, fit) and found.excess < best.excess:
            best = found
        elif best is not fit:
            break
    return best


def _moves(search, fit, place):
    """Shares of its first step that each value should move by, as the slopes have it, for ever more damping."""
    numbers, slopes = _slopes(search.gram, fit.chosen[place], fit.strengths[place])
    rows = search.gram.gathered(search.columns(fit.chosen))
    products = search.gram.products([np.concatenate(both) for both in zip(rows, slopes)])
    own = np.arange(len(products) - 1 - len(numbers), len(products) - 1)
    for damping in DAMPINGS:
        damped, moves = products.copy(), np.zeros(len(fit.chosen[place].family.values))
        damped[own, own] += damping * max(fit.excess, 1.0)
        moves[numbers] = solve(damped)[own]
        yield np.clip(moves, -1.0, 1.0)


def _slopes(gram, candidate, strengths):
    """(numbers of the values that can move, what each changes in the rows, by its first step: (values, rows) a layout)."""

    def shown(one):
        return [np.tensordot(strengths, rows, 1) for rows in gram.gathered(one.columns)]

    near = {}  # number of a value: the side to which it can move, and the candidate there
    for number, side in itertools.product(range(len(candidate.family.values)), (1, -1)):
        if number not in near and (other := candidate.family.beside(number, SLOPE_SHARE, side)) is not None:
            near[number] = side, other
    gram.make([column for _, other in near.values() for column in other.columns])
    here = shown(candidate)
    found = [[side * (there - rows) / SLOPE_SHARE for there, rows in zip(shown(other), here)] for side, other in near.values()]
    every = [[one[number] for one in found] for number in range(len(here))]
    return list(near), [np.array(rows).reshape(len(near), len(plain)) for rows, plain in zip(every, here)]
