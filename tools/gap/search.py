"""Which effects: greedy over all candidates with a beam, every step judged on held-out blocks."""

import numpy as np

from .catalogue import candidates
from .gram import Gram
from .scene import Extent, Scene

# docs/diagnosis.md has the reason of each
TOLERATED_PER_FREEDOM = 0.10  # excess that the reconstruction itself leaves, per degree of freedom
TOLERATED_OF_SIGNAL = 0.007  # and of the measured torque
LEAST_STEP = 40.0  # chi-square
LEAST_STEP_PER_FREEDOM = 0.0075
LEAST_Z = 3.0  # of the gain over blocks
SECOND_MUST_CLOSE = 0.45  # of what the first leaves
THIRD_MUST_CLOSE = 0.60
CLOSED_ENOUGH = 0.01  # of the excess: no further effect is looked for
COLUMN_PRICE = 2.0  # chi-square for each further column, whose choice the folds do not see
BEAM = 3


class Fit:
    """A set of candidates fitted together."""

    def __init__(self, chosen, excess, strengths=()):
        self.chosen, self.excess, self.strengths = list(chosen), excess, strengths


class Search:
    """Candidates at identified base parameters, and the fits among them."""

    def __init__(self, evidence, base):
        self.evidence = evidence
        self.scenes = [Scene(evidence, record, base) for record in range(len(evidence.tracks))]
        self.extent = Extent(self.scenes)
        self.gram = Gram(evidence, self.scenes, candidates(evidence, self.scenes, self.extent))
        self.freedom = evidence.freedom()
        self.plain = self.fit([])
        self.tolerated = TOLERATED_PER_FREEDOM * self.freedom + TOLERATED_OF_SIGNAL**2 * self._signal()

    def _signal(self):
        """Sum of squares of all torques over their noise."""
        return sum(float(c.values[c.rows] @ c.values[c.rows]) / self.evidence.sigma[c.kind] ** 2
                   for c in self.evidence.channels if c.kind[0] == "T")  # fmt: skip

    def columns(self, chosen):
        return [place for candidate in chosen for place in self.gram.of(candidate)]

    def fit(self, chosen):
        """The excess over noise that these candidates leave on held-out blocks, and each one's strengths."""
        chi2, strengths = self.gram.held_out(self.columns(chosen))
        return self._fit(chosen, chi2, strengths)

    def _fit(self, chosen, chi2, strengths):
        rest, own = list(strengths), []
        for candidate in chosen:
            own.append([rest.pop(0) for _ in candidate.columns])
        price = COLUMN_PRICE * sum(len(c.columns) - 1 for c in chosen)
        return Fit(chosen, chi2 - self.freedom + price, own)

    def beside(self, chosen, candidates):
        """Fits of each candidate beside the chosen ones; those out of physical range are left out."""
        found = self.gram.scan(self.columns(chosen), candidates)
        fits = [self._fit([*chosen, c], chi2, strengths) for c, (chi2, strengths) in zip(candidates, found)]
        return [fit for fit in fits if all(c.within_range(s) for c, s in zip(fit.chosen, fit.strengths))]

    def scan(self, chosen):
        """The best shape of every (effect, joint) beside the chosen ones, best first."""
        best, taken = {}, {c.key for c in chosen}
        for fit in self.beside(chosen, [c for c in self.gram.candidates if c.key not in taken]):
            key = fit.chosen[-1].key
            if key not in best or fit.excess < best[key].excess:
                best[key] = fit
        return sorted(best.values(), key=lambda fit: fit.excess)

    def reshaped(self, fit):
        """Each chosen effect's shape looked for anew beside the others."""
        for i, old in enumerate(fit.chosen):
            others = [*fit.chosen[:i], *fit.chosen[i + 1:]]
            for found in self.beside(others, [c for c in self.gram.candidates if c.key == old.key]):
                if found.excess < fit.excess - 1e-9:
                    order = [*fit.chosen[:i], found.chosen[-1], *fit.chosen[i + 1:]]
                    fit = Fit(order, found.excess, [*found.strengths[:i], found.strengths[-1], *found.strengths[i:-1]])
        return fit

    def significant(self, before, after, share):
        """Is the step from one fit to another worth an effect? `share` of what is left must be closed."""
        old, new = (self.gram.held_out_blocks(self.columns(fit.chosen)) for fit in (before, after))
        filled = old > 0
        gain, record = (old - new)[filled], self.evidence.block_record[filled]
        # where blocks differ much in size, the sum is one block's word: relative gains give each block its own
        z = max(over_blocks(gain, record), over_blocks(gain / (old + new)[filled], record))
        tempered = (before.excess - after.excess) / max(1.0, (after.excess + self.freedom) / self.freedom)
        closed = before.excess - after.excess > share * max(before.excess - self.tolerated, 0)
        enough = tempered > LEAST_STEP + LEAST_STEP_PER_FREEDOM * self.freedom
        return bool(enough and z > LEAST_Z and closed)

    def extended(self, singles):
        """One to three effects, from the ranking of single ones."""
        best = singles[0]
        if not self._worth_more(best):
            return best
        following = [found[0] for start in singles[:BEAM] if (found := self.scan(start.chosen))]
        if not following:
            return best
        second = self.reshaped(min(following, key=lambda fit: fit.excess))
        if not self.significant(best, second, SECOND_MUST_CLOSE):
            return best
        if self._worth_more(second) and (third := self.scan(second.chosen)):
            if self.significant(second, third[0], THIRD_MUST_CLOSE):
                return self.ordered(third[0])
        return self.ordered(second)

    def _worth_more(self, fit):
        left = max(fit.excess - self.tolerated, 0)
        return left > CLOSED_ENOUGH * self.plain.excess

    def ordered(self, fit):
        """The effect without which the rest is worst comes first."""
        without = [self.fit([c for c in fit.chosen if c is not one]).excess for one in fit.chosen]
        return self.fit([fit.chosen[i] for i in np.argsort(without)[::-1]])


def over_blocks(gain, record):
    """The sum of gains over its standard deviation, by their spread within each recording: recordings differ in
    regime, not in noise."""
    variance = 1e-9
    for r in np.unique(record):
        if (record == r).sum() > 1:
            variance += (record == r).sum() * gain[record == r].var(ddof=1)
    return gain.sum() / np.sqrt(variance)


def plain_base(evidence):
    """Base parameters of the plain model by weighted least squares on the scored rows."""
    return Gram(evidence, [None] * len(evidence.tracks), []).fold_strengths([])[-1][:evidence.bases]


def search(evidence, base, step=lambda text: None):
    """(search, fit): the search at the parameters that suit the best effect, and the effects chosen."""
    step("candidates")
    first = Search(evidence, base)
    step("single effects")
    singles = first.scan([])
    if not singles or not first.significant(first.plain, singles[0], 0.0):
        return first, first.plain
    # candidates are made of the plain model's torques: once more, at parameters fitted with the best effect
    again = first.gram.fold_strengths(first.columns(singles[0].chosen))[-1][:evidence.bases]
    del singles
    if np.all(np.isfinite(again)):
        del first
        step("candidates, once more")
        first = Search(evidence, again)
    step("combinations")
    singles = first.scan([])
    return first, first.extended(singles) if singles else first.plain
