"""Does a verdict survive another low-pass? What is named at one frequency alone may be what the filter left."""

import numpy as np

from ..figures import by_candidate, standard_errors
from ..gram import Gram
from ..torque_terms import TorqueTerms
from .halves import alone
from .thresholds import DEVIATIONS, PART, RIGHT_TO

MOST_RIVALS = 4


class Other:
    """Effects fitted to rows through another low-pass."""

    def __init__(self, search, dataset):
        self.search, self.dataset = search, dataset
        terms = search.all_terms[0]
        self.all_terms = [TorqueTerms(dataset, record, terms.base, terms.torque_constant_error)
                          for record in range(len(dataset.processed_recordings))]  # fmt: skip

    def excess(self, chosen):
        """Chi-square over noise that candidates leave on held-out blocks."""
        return self._held_out(chosen)[0] - self.dataset.freedom()

    def moved(self, fit, errors, within):
        """Keys of a fit's effects that have other strengths there: by more than DEVIATIONS of their `errors`, and what is beyond that does
        more to the readings than the share `within` of what the effect does, both as far as no other parameter does the same."""
        gram, keys = Gram(self.dataset, self.all_terms, fit.chosen), set()
        strengths = by_candidate(fit, gram.held_out(self.search.columns(fit.chosen))[1])
        for candidate, here, there, error in zip(fit.chosen, fit.strengths, strengths, errors, strict=True):
            change = np.subtract(there, here)
            beyond = np.sign(change) * np.maximum(np.abs(change) - DEVIATIONS * np.array(error), 0.0)
            if np.any(beyond):
                others = [c for c in fit.chosen if c is not candidate]
                rows = alone(gram.plain, gram.gathered(self.search.columns([*others, candidate])), len(here))
                if shown(rows, beyond) > within * shown(rows, np.array(here)):
                    keys.add(candidate.key)
        return keys

    def excess_and_cost(self, chosen, temperature):
        """(excess, the same with what the machine beside them costs that is not the model file's, at a likelihood temperature)."""
        gram, columns = Gram(self.dataset, self.all_terms, chosen), self.search.columns(chosen)
        excess = gram.held_out(columns)[0] - self.dataset.freedom()
        return excess, excess + temperature * gram.off_drawing(columns, temperature)

    def _held_out(self, chosen):
        return Gram(self.dataset, self.all_terms, chosen).held_out(self.search.columns(chosen))


def shown(rows, strengths):
    """What columns with these strengths do to the readings: root of the sum of squares, over the noise."""
    return float(np.sqrt(sum(np.sum((strengths @ one) ** 2) for one in rows)))


def survives(search, fit, rivals, dataset):
    """Is the first effect of a fit still the best there, or as good as the best by what forms differ by anyhow, worth having, and of the
    same size but for PART, for no form is exact? `dataset` holds the same recordings through another low-pass, over the same noise."""
    dataset.sigma = dict(search.dataset.sigma)
    other, (first, *others) = Other(search, dataset), fit.chosen
    temperature = search.temperature_of(fit)
    named, cost = other.excess_and_cost([first, *others], temperature)
    beside = [other.excess_and_cost(rival.chosen, temperature)[1] for rival in rivals[:MOST_RIVALS] if rival.chosen[-1].key != first.key]
    near = search.detection_threshold + search.tolerated + temperature
    worth = named < other.excess(others) - search.detection_threshold and cost < min(beside, default=cost) + near
    return bool(worth) and first.key not in other.moved(fit, standard_errors(search, fit), PART)


def keep_their_size(search, fit, datasets):
    """Keys of a fit's effects that have the same strengths through other low-passes, as far as these are known and forms are right. A law
    has; what the sensors or the filter did has another size through another filter."""
    errors, moved = standard_errors(search, fit), set()
    for dataset in datasets:
        dataset.sigma = dict(search.dataset.sigma)
        moved |= Other(search, dataset).moved(fit, errors, RIGHT_TO)
    return {candidate.key for candidate in fit.chosen} - moved
