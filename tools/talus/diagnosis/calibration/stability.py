"""Does a verdict survive another low-pass? What is named at one frequency alone may be what the filter left."""

from ..gram import Gram
from ..torque_terms import TorqueTerms

MOST_RIVALS = 4


class Half:
    """The named effect and its nearest rivals, fitted to rows through half the low-pass."""

    def __init__(self, search, dataset):
        self.search, self.dataset = search, dataset
        terms = search.all_terms[0]
        self.all_terms = [TorqueTerms(dataset, record, terms.base, terms.torque_constant_error)
                          for record in range(len(dataset.processed_recordings))]  # fmt: skip

    def excess(self, chosen):
        """Chi-square over noise that candidates leave on held-out blocks."""
        gram = Gram(self.dataset, self.all_terms, chosen)
        chi2 = gram.held_out([column for candidate in chosen for column in candidate.columns])[0]
        return chi2 - self.dataset.freedom()


def survives(search, fit, rivals, dataset):
    """Is the first effect of a fit still the best there, or as good as the best, and worth having? `dataset` holds the same
    recordings through half the low-pass, over the same noise."""
    dataset.sigma = dict(search.dataset.sigma)
    half, (first, *others) = Half(search, dataset), fit.chosen
    named = half.excess([first, *others])
    without = half.excess(others)
    beside = [half.excess(rival.chosen) for rival in rivals[:MOST_RIVALS] if rival.chosen[-1].key != first.key]
    near = search.detection_threshold + search.tolerated
    return bool(named < without - search.detection_threshold and named < min(beside, default=named) + near)
