"""How much evidence an experiment would bring between two explanations: the chi-square by which the wrong one fails on old
and new recordings together, its own parameters and the base parameters fitted anew to both.
"""

import numpy as np

from ..gram import Gram, solve, squares


class Explanation:
    """One cause in the shapes that it could take, the best first, each with the further effects; `name` for words and the
    excess that the best one leaves."""

    def __init__(self, name, sets, excess):
        self.name, self.sets, self.excess = name, sets, excess


def columns_of(chosen):
    return [column for candidate in chosen for column in candidate.columns]


def total(gram, columns):
    """Products of base columns, some columns and, last, the reading, over all folds."""
    out = gram.bordered(gram.gathered(columns)).sum(0)
    order = [*range(gram.first), *range(gram.first + 1, len(out)), gram.first]
    return out[np.ix_(order, order)]


def with_reading(products, strengths):
    """Products whose reading is the columns with these strengths."""
    out = products.copy()
    out[:-1, -1] = out[-1, :-1] = products[:-1, :-1] @ strengths
    out[-1, -1] = strengths @ products[:-1, :-1] @ strengths
    return out


def left(products):
    """What the best fit leaves of the reading."""
    return float(squares(products, solve(products)))


class Pair:
    """One explanation against another on the recordings there are."""

    def __init__(self, search, truth, rival):
        self.truth, self.rivals, gram = truth, rival.sets, search.gram
        self.strengths = solve(total(gram, search.columns(truth)))
        self.old = [total(gram, search.columns(chosen)) for chosen in self.rivals]
        self.before = min(left(products) for products in self.old)

    def gain(self, gram, first):
        """Chi-square that the planned recordings `gram` would add to the rival's, were `truth` true."""
        mine, found = columns_of(self.truth), []
        for chosen, old in zip(self.rivals, self.old):
            own = columns_of(chosen)
            every = list(dict.fromkeys(mine + own))
            new = total(gram, every)
            strengths = np.zeros(len(new) - 1)
            strengths[:first] = self.strengths[:first]
            for column, strength in zip(mine, self.strengths[first:]):
                strengths[first + every.index(column)] += strength
            keep = [*range(first), *(first + every.index(c) for c in own), len(new) - 1]
            found.append(left(old + with_reading(new, strengths)[np.ix_(keep, keep)]))
        gain = min(found) - self.before
        return max(gain, 0.0) if np.isfinite(gain) else 0.0


class Contest:
    """What is to be told apart: the named explanation against each other one, whichever is true; `temperature` is the
    verdict's as it stands."""

    def __init__(self, search, named, others, temperature):
        self.first, self.named, self.others, self.temperature = search.gram.first, named, others, temperature
        self.sizes = [[len(columns_of(one.sets[0])) for one in (named, other)] for other in others]
        self.pairs = [(Pair(search, named.sets[0], other), Pair(search, other.sets[0], named)) for other in others]
        nothing = Explanation("no effect", [[]], search.plain.excess)
        self.plain = [Pair(search, one.sets[0], nothing) for one in (named, *others)]
        self.candidates = list(dict.fromkeys(c for one in (named, *others) for chosen in one.sets for c in chosen))

    def keys(self, numbers):
        """Effect and joint of some of the others."""
        first = [self.others[k].sets[0][0] for k in numbers]
        return [{"effect": candidate.effect, "joint": candidate.joint} for candidate in first]

    def gains(self, planned):
        """For each other explanation the chi-square that the experiment adds were the named one true, and were the other
        true, (others, 2); and what it adds to the plain model's at the most."""
        gram = Gram(planned.dataset, [planned.terms], self.candidates)
        gains = np.array([[pair.gain(gram, self.first) for pair in both] for both in self.pairs])
        return gains, max(pair.gain(gram, self.first) for pair in self.plain)
