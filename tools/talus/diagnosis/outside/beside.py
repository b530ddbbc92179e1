"""How likely is what is outside the catalogue, beside its effects?"""

import math

from ..calibration.thresholds import HALF, LOGIT_WIDTH, NEARLY_HALF
from ..catalogue.candidate import COLUMN_PENALTY
from ..machine.drawing import against

HOPELESS = 60.0  # twice the logarithm of the odds: what has so much against it


def numbers_fitted(fit):
    """How many numbers the forms of a fit have to suit: their strengths, and the values of their shapes."""
    return sum(len(c.columns) + (len(c.family.values) if c.family else 0) for c in fit.chosen)


def further_columns(fit):
    """How many columns its forms have beyond one each."""
    return sum(len(c.columns) - 1 for c in fit.chosen)


class Beyond:
    """The set of effects that may hold causes outside the catalogue, beside the one that holds effects alone. `probability`: that the
    gap is such a cause, and the named effect its imitation; what may be the sensors' work (they are not `sound`, or replicates gain as
    much) is no likelier than not."""

    def __init__(self, search, fit, sound=True):
        self.search, self.fit, self.other = search, fit, search.with_outsiders
        self.first = next((c for c in self.other.chosen if search.is_outside(c.key)), None) if self.other else None
        self.takes = self._share_taken() if self.first else 0.0
        self.probability = self._probability() if self.first else 0.0
        self.by_drawing = False  # do the effects explain as much, but beside another machine?
        self._weigh_drawing()
        if self.first and not (sound and self._outdoes_replicates()):
            self.probability = min(self.probability, NEARLY_HALF)

    def _share_taken(self):
        """Probability by the share that the other set closes of what the effects leave, over all channels, those at its joint, or the
        torque there alone: what neither touches says nothing about them. One with fewer numbers is a rival like any other besides."""
        mine, theirs = (self.search.held_out_excess(one.chosen) for one in (self.fit, self.other))
        return max(self._as_rival(), *(self._taken_in(kinds, mine, theirs) for kinds in self.search.dataset.scopes_at(self.first.joint)))

    def _as_rival(self):
        """Probability of the other set, where it is the simpler one and leaves less, by the odds of rivals: rough forms take up what anything
        leaves, but not with fewer numbers than the effects have."""
        less = self.fit.excess - self.other.excess
        if less <= 0.0 or not self._is_simpler():
            return 0.0
        fewer = further_columns(self.fit) - further_columns(self.other)
        odds = 0.5 * less / self.search.temperature_of(self.fit) + COLUMN_PENALTY * fewer
        return 1.0 / (1.0 + math.exp(-min(odds, HOPELESS)))

    def _is_simpler(self):
        return numbers_fitted(self.other) < numbers_fitted(self.fit)

    def _taken_in(self, kinds, mine, theirs):
        """Probability by the share closed in some kinds of channel: at half of it, as likely as not. What reconstruction leaves as well is
        no reason for another set, unless that is the simpler one, too."""
        least = self.search.detection_threshold if self._is_simpler() else sum(self.search.floor_of[kind] for kind in kinds)
        left, then = (max(sum(excess[kind] for kind in kinds), least) for excess in (mine, theirs))
        if then >= left:
            return 0.0
        return 1.0 / (1.0 + ((then / (left - then)) * (1.0 - HALF) / HALF) ** (1.0 / LOGIT_WIDTH))

    def _probability(self):
        if not self.fit.chosen:
            return 1.0 - self.search.nothing(self.search.plain, self.search.fit([self.first]))
        return 0.0 if self._has_the_named() else self.takes

    def _weigh_drawing(self):
        """A cause that explains the recordings as well as the effects do, and leaves the machine the one of the model file where these
        need another: by how much, with what both leave above what reconstruction does, over what one of so many causes has by chance."""
        search, least = self.search, max(self.search.detection_threshold, sum(self.search.floor_of.values()))
        near = [one for one in search.outside_alone if self.fit.chosen and one.excess < max(self.fit.excess, least)]
        if not near:
            return
        temperature = search.temperature_of(self.fit)
        nearest, one = min(((against(search, one, temperature, least), one) for one in near), key=lambda pair: pair[0])
        more = against(search, self.fit, temperature, least) - nearest - search.chance
        probability = 1.0 / (1.0 + math.exp(min(-0.5 * more, HOPELESS)))
        if probability > self.probability:
            self.probability, self.first, self.by_drawing = probability, one.chosen[0], True

    def _outdoes_replicates(self):
        """Does the cause gain more than the readings alone gain anything?"""
        gain = self.search.plain.excess - self.search.fit([self.first]).excess
        return not self.search.calibration.outdone(gain)

    def _has_the_named(self):
        """Does the named effect stand in front of the other set, too?"""
        return bool(self.other) and self.other.chosen[0].key == self.fit.chosen[0].key

    def instead(self):
        """[(probability, candidate)] of what stands in the effects' place."""
        return [(self.probability, self.first)] if self.first and self.probability > 0 else []

    def add_to(self, verdict):
        """What stands beside the named effect is told, and in the place of a further one it takes that one's probability."""
        if not self.first or not self._has_the_named():
            return
        there = {c.key for c in self.other.chosen}
        for key in set(verdict.further) - there:
            verdict.further[key] *= 1.0 - self.takes
        outside = [c for c in self.other.chosen if self.search.is_outside(c.key)]
        verdict.resembles = [(verdict.known * self.takes, c) for c in outside]
