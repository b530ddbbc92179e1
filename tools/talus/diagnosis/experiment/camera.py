"""What a camera that sees both links would add: it parts what an encoder shows from what the link does."""

import math

import numpy as np

from ..effects import known
from ..verdict import CONFUSABLE_ABOVE
from .menu import LONGEST_S, MARGIN
from .planned import Planned

CAMERA_RAD = 1e-3  # noise of one angle, as a marker tracker has it


def helps(search, effects):
    """Would a camera part these effects, and has none been there?"""
    return search.dataset.at_motor and all(effect.needs == "camera" for effect in known(effects)) and "F" not in search.dataset.kinds


def shown(search, explanation, terms):
    """The camera's angle between the links, less the motors', that an explanation predicts."""
    chosen, out = explanation.sets[0], np.zeros(len(terms.processed.grid_t_s))
    for candidate, strengths in zip(chosen, search.fit(chosen).strengths):
        for column, strength in zip(candidate.columns, strengths):
            out = out + strength * column(terms).get("F", 0.0)
    return out


def gains(search, contest, q):
    """Chi-square for each other explanation along the motion q; the mean is the camera's alignment."""
    terms = Planned(search, q, camera=True).terms
    rows = next(c.rows for c in terms.dataset.channels if c.kind == "F")
    named, *others = (shown(search, one, terms)[rows] for one in (contest.named, *contest.others))
    return [float(np.sum((other - named - np.mean(other - named)) ** 2) / (2 * CAMERA_RAD**2)) for other in others]


def needed(search, verdict):
    """Chi-square that leaves no other explanation confusable, from the odds as they are."""
    first = verdict.probabilities[0][0]
    return [2 * MARGIN * search.chance * math.log(p / (CONFUSABLE_ABOVE * first)) for p, _, _ in verdict.confusable()]


class Filmed:
    """One motion with a camera: how often it must run, and which of the others it then parts."""

    def __init__(self, search, verdict, contest, option):
        self.option, self.needed, self.each = option, needed(search, verdict), gains(search, contest, option.q)
        most = max(1, int(LONGEST_S / option.length_s))
        self.repeats = next((n for n in range(1, most) if len(self.parted(n)) == len(self.each)), most)
        self.parts = self.parted(self.repeats)
        self.length_s = self.repeats * option.length_s

    def parted(self, repeats):
        return [k for k, (gain, least) in enumerate(zip(self.each, self.needed)) if repeats * gain >= least]

    def rank(self):
        """Smaller is better: what it parts, its length, what it brings in that time."""
        return -len(self.parts), self.length_s, -min(self.each)


def best(search, verdict, contest, options):
    """The motion that a camera sees most of."""
    return min((Filmed(search, verdict, contest, option) for option in options), key=Filmed.rank)
