"""The chosen effects once more, for the model file: their shapes between the grid's, their strengths and the model's
physical parameters together."""

import numpy as np

from .effects import torque_constant_error
from .gram import Gram
from .machine.physical import constrained
from .torque_terms import TorqueTerms

REWEIGHINGS = 4
STEP_SHARES = (0.5, 0.35, 0.25, 0.15, 0.1, 0.06)  # of a shape's first step
DETECTION_THRESHOLD = 1.0  # of the cost: less is not worth another shape
MOST_FITS, STAYS = 4, 2e-3
RIDGE = 1e-10  # of unit columns: keeps what cannot be told apart solvable


class Rows:
    """All weighted rows of a search for some effects, channel kind after channel kind: (unknowns, rows) of base columns,
    constants and the effects' columns, and the readings."""

    def __init__(self, search, chosen):
        every = [search.gram.gathered(candidate.columns) for candidate in chosen]
        self.parts = [(np.concatenate([plain[:-1], *own]), plain[-1])
                      for plain, *own in zip(search.gram.plain, *every)]  # fmt: skip
        known, self.prior_reading = search.gram.prior_rows()
        self.prior_share = search.gram.prior_share
        self.prior = np.vstack([known, np.zeros((len(self.parts[0][0]) - len(known), known.shape[1]))])
        self.norm = np.sqrt(sum((rows**2).sum(1) for rows, _ in self.parts))
        self.used = np.flatnonzero(self.norm > 0)

    def solve(self, weights):
        """The unknowns that fit best (0 where nothing tells), with a weight for each kind."""
        share = self.prior_share(weights)
        gram, right = share * self.prior @ self.prior.T, share * self.prior @ self.prior_reading
        for (rows, reading), w in zip(self.parts, weights):
            gram, right = gram + w * w * rows @ rows.T, right + w * w * rows @ reading
        gram, right = gram[np.ix_(self.used, self.used)], right[self.used]
        unit, out = self.norm[self.used], np.zeros(len(self.norm))
        scaled = gram / np.outer(unit, unit) + RIDGE * np.eye(len(unit))
        out[self.used] = np.linalg.solve(scaled, right / unit) / unit
        return out

    def left(self, x):
        """Mean square that unknowns leave of each kind, in units of its noise."""
        return np.array([np.mean((reading - x @ rows) ** 2) for rows, reading in self.parts])

    def settle(self):
        """(weights, unknowns, cost): every kind counts by what is left of it, not by its noise alone. An encoder is so
        fine that what a law leaves of it would outweigh the torque, which is what a model file predicts."""
        weights = np.ones(len(self.parts))
        for _ in range(REWEIGHINGS):
            found = self.solve(weights)
            weights = 1.0 / np.sqrt(np.maximum(self.left(found), 1.0))
        count = np.array([len(reading) for _, reading in self.parts])
        return weights, found, float(count @ np.log(np.maximum(self.left(found), 1.0)))


def cost(search, chosen, i):
    """Of the chosen effects together; infinite where the i-th is out of its range."""
    rows = Rows(search, chosen)
    _, found, value = rows.settle()
    first = search.gram.first + sum(len(c.columns) for c in chosen[:i])
    own = found[first:first + len(chosen[i].columns)]
    return value + 2 * len(own) if chosen[i].within_range(own) else np.inf


def best_shapes(search, chosen):
    """The chosen effects, those that show in angles, too, in the shapes that suit all kinds of readings alike: the search
    has taken the shapes that suit the finest sensor."""
    chosen = [part for c in chosen for part in (c.parts or (c,))]
    for i, old in enumerate(chosen):
        if not any(set(column(search.all_terms[0])) & {"E", "K", "F"} for column in old.columns):
            continue
        alone = [c.key for c in chosen].count(old.key) == 1
        others = [old, *(c for c in search.gram.candidates if alone and c.key == old.key)]
        costs = [cost(search, [*chosen[:i], other, *chosen[i + 1:]], i) for other in others]
        chosen[i] = others[int(np.argmin(costs))]
        search.gram.forget(chosen)
        moved(search, chosen, i, min(costs))
    return chosen


def moved(search, chosen, i, least):
    """Moves the i-th effect's shape downhill, one value after the other, with ever smaller steps."""
    for share in STEP_SHARES:
        for number in range(len(chosen[i].family.directions) if chosen[i].family else 0):
            for side in (1, -1):
                other = chosen[i].family.beside(number, share, side)
                value = np.inf if other is None else cost(search, [*chosen[:i], other, *chosen[i + 1:]], i)
                if value < least - DETECTION_THRESHOLD:
                    chosen[i], least = other, value
                    break
        search.gram.forget(chosen)


class Anew:
    """The chosen effects' rows on torque terms at other base parameters: what of a law hangs on load or friction moves with them."""

    def __init__(self, search, chosen, base, excess):
        self.dataset = search.dataset
        self.all_terms = [TorqueTerms(self.dataset, record, base, excess) for record in range(len(self.dataset.processed_recordings))]
        self.gram = Gram(self.dataset, self.all_terms, chosen)
        self.gram.prior_width, self.gram.drawn = search.gram.prior_width, search.gram.drawn


def settled_fit(search, chosen, model):
    """joint_fit(), its columns made anew at the parameters found until these stay."""
    search.gram.keep(chosen)
    found = joint_fit(search, chosen, model)
    for _ in range(MOST_FITS):
        trial = model.copy()
        trial.set_parameters(**found[0])
        before, base, excess = search.all_terms[0], np.array(list(trial.base.values())), torque_constant_error(chosen, found[1])
        if np.allclose([*base, 1 + excess], [*before.base, 1 + before.torque_constant_error], rtol=STAYS, atol=0):
            break
        for terms in search.all_terms:
            terms.give_up()  # these and the next would be the most that a run holds
        search = Anew(search, chosen, base, excess)
        found = joint_fit(search, chosen, model)
    return found


def joint_fit(search, chosen, model):
    """Effects fitted together with the model's physical parameters, within the bounds of both: (parameters, strengths of
    each effect, chi-square that the bounds cost). A parameter that the recordings do not move keeps its prior."""
    rows = Rows(search, chosen)
    bases = len(model.base)
    used = np.union1d(np.arange(bases), rows.used)
    weights, best, _ = rows.settle()
    every = [np.sqrt(rows.prior_share(weights)) * rows.prior[used], *(w * part[used] for (part, _), w in zip(rows.parts, weights))]
    root = np.linalg.qr(np.hstack(every).T, mode="r")
    free = np.full(search.gram.first - bases, np.inf)
    low, high = (np.concatenate([sign * free, *(limits(c, side) for c in chosen)]) for sign, side in ((-1, 0), (1, 1)))
    seen = used[bases:] - bases
    values, others, lost = constrained(model, root, best[used], low[seen], high[seen])
    rest = np.zeros(len(low))
    rest[seen] = others
    rest, strengths = list(rest[len(free):]), []
    for candidate in chosen:
        strengths.append([rest.pop(0) for _ in candidate.columns])
    return values, strengths, lost


def limits(candidate, side):
    """Lowest (0) or highest (1) strengths that are physical."""
    given = (candidate.low, candidate.high)[side]
    return np.full(len(candidate.columns), (-np.inf, np.inf)[side]) if given is None else np.asarray(given, float)
