"""Studies of many trials, and their figures with Monte-Carlo standard errors. A study of one size is made once in a process."""

import functools
from dataclasses import dataclass
from math import log, sqrt

import numpy as np
from scipy.stats import spearmanr
from support import many

from talus.diagnosis import search as real
from talus.diagnosis.calibration import gains
from talus.diagnosis.verdict import HOPELESS

from . import exact, trials
from .toy import BASE_NM, ToyDataset, stand_ins

WHOLE = {"useless": 2000, "rough": 4100, "white": 4100, "outside": 2000, "wide": 2000, "measured": 2500, "choices": 2500}
SLOW = ("rough", "white", "outside", "wide")  # with replicates
SIZES = {
    "fast": {"useless": 300, "rough": 140, "white": 140, "outside": 80, "wide": 60, "measured": 260, "choices": 120},
    "whole": {name: many(number) if name in SLOW else number for name, number in WHOLE.items()},
}
NUMBER = {name: k for k, name in enumerate(WHOLE)}  # of a study, its seed
EDGES = (0.0, 0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
ODDS = 20.0  # above which evidence decides
STANDING_OUT = (4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0)  # an effect's strength, in standard deviations of its estimate


@functools.cache
def study(name, sizes):
    """The trials of a study, of these `sizes`; each trial has a seed of its own. `both`: a twelfth hides what no effect explains."""
    if name == "both":
        return study("rough", sizes) + study("outside", sizes)
    make = {
        "rough": functools.partial(trials.from_the_prior, rough=True),
        "white": functools.partial(trials.from_the_prior, rough=False),
        "outside": functools.partial(trials.from_the_prior, rough=True, outside=0.25),
        "wide": functools.partial(trials.from_the_prior, rough=True, spread=2.0, something=False),
        "measured": trials.measured,
        "choices": trials.choice,
    }[name]
    count = SIZES[sizes][name]
    with stand_ins():
        found = [make(np.random.default_rng([NUMBER[name], number])) for number in range(count)]
    return [one for one in found if one is not None]


@functools.cache
def useless(sizes):
    """(weights of Imhof's sum, gains by talus-gap): of one effect in many recordings of one toy, where nothing is hidden."""
    random = np.random.default_rng([NUMBER["useless"]])
    toy, found = trials.problem(random, rough=False), []
    key = toy.candidates[0].key
    with stand_ins():
        for _ in range(SIZES[sizes]["useless"]):
            dataset = ToyDataset(toy, toy.recording(np.zeros(trials.EFFECTS)))
            found.append(gains.gains_beside(real.Search(dataset, BASE_NM), [])[key])
    return exact.weights_of_gain(toy, dataset, 0), np.array(found)


def standard_error(share, number):
    return sqrt(max(share * (1 - share), 1 / number) / number)


# ---- what is taken where nothing is hidden -----------------------------------------------


@dataclass
class Family:
    """Recordings where nothing is hidden."""

    number: int
    taken: int
    named: int
    promise: float  # upper bound of the share that is taken, by the formula


def family(found):
    nothing = [one for one in found if one.truth is None]
    return Family(len(nothing), sum(bool(one.taken) for one in nothing), sum(one.named not in ("none", "unknown") for one in nothing),
                  float(np.mean([one.promise for one in nothing])))  # fmt: skip


# ---- probabilities -----------------------------------------------------------------------


@dataclass
class Bin:
    """Trials of which nearly the same probability was claimed."""

    number: int
    claimed: float
    true: int

    @property
    def share(self):
        return self.true / self.number


def bins(claimed, true, edges=EDGES):
    claimed, true = np.array(claimed), np.array(true)
    place = np.clip(np.searchsorted(edges, claimed, side="right") - 1, 0, len(edges) - 2)
    return [Bin(int(np.sum(place == k)), float(claimed[place == k].mean()), int(true[place == k].sum())) for k in np.unique(place)]


def none_bins(found):
    """Of P(none), beside how often nothing was hidden."""
    return bins([one.none for one in found], [one.truth is None for one in found])


def no_cause_bins(found):
    """Of P(none) and P(unknown) together, beside how often no effect was hidden."""
    return bins([one.none + one.unknown for one in found], [one.truth in (None, trials.OUTSIDE) for one in found])


# ---- intervals ---------------------------------------------------------------------------


@dataclass
class Coverage:
    """Intervals of effects that stand out by about so many deviations."""

    low: float
    number: int
    covered: float
    taken: int
    covered_if_taken: float
    by_theory: float  # of the last, if exactly the largest estimates were taken


def coverages(found, edges=STANDING_OUT):
    return [_coverage(low, [one for one in found if low <= one.deviations < high]) for low, high in zip(edges, edges[1:])]


def _coverage(low, own):
    taken = [one.covered for one in own if one.taken]
    half_width = float(np.mean([one.half_width for one in own]))
    return Coverage(low, len(own), float(np.mean([one.covered for one in own])), len(taken), float(np.mean(taken or [np.nan])),
                    exact.covered_if_taken(max(len(taken), 1) / len(own), half_width))  # fmt: skip


# ---- choice ------------------------------------------------------------------------------


@dataclass
class Pairs:
    """Logarithms of the odds of the likeliest effect against others, as the shares have them and exactly; and the temperatures."""

    exact: np.ndarray
    shares: np.ndarray
    temperature: np.ndarray


def pairs(found, alike=False):
    """Against all others that have a share at all, or only the one that is like it."""
    rows = []
    for one in found:
        best = int(np.argmax(one.shares))
        for k in [best ^ 1] if alike else [k for k in range(trials.EFFECTS) if k != best]:
            if np.isfinite(one.shares[k]):
                rows.append((one.exact[best] - one.exact[k], one.shares[best] - one.shares[k], one.temperature))
    return Pairs(*np.array(rows).T)


def agreement(found):
    """(trials whose exact odds exceed ODDS, those of them of which both have the same likeliest effect)"""
    decided = [one for one in found if np.diff(np.sort(one.exact)[-2:])[0] > log(ODDS)]
    return len(decided), sum(int(np.argmax(one.exact)) == int(np.argmax(one.shares)) for one in decided)


def rank_correlation(found):
    """Of the odds against all others. Shares are 0 beyond what they call hopeless, and so count as that: on both sides alike."""
    rows = []
    for one in found:
        best = int(np.argmax(one.shares))
        for k in range(trials.EFFECTS):
            if k != best:
                most = 0.5 * HOPELESS
                rows.append((min((one.exact[best] - one.exact[k]) / one.temperature, most), min(one.shares[best] - one.shares[k], most)))
    return float(spearmanr(*np.array(rows).T)[0])


def cooling(found):
    """Logarithm of the shares' odds times the temperature, over that of the exact odds: 1 where shares are the tempered evidence."""
    both = pairs(found, alike=True)
    clear = both.exact > 3
    return (both.shares * both.temperature / both.exact)[clear]


def likeliest_bins(found, of="shares"):
    """Of the likeliest effect's share, or its exact probability (in the same bins), beside how often it is the true one."""
    best = [int(np.argmax(getattr(one, of))) for one in found]
    claimed = [float(np.exp(getattr(one, of)[k])) for one, k in zip(found, best, strict=True)]
    return bins(claimed, [k == one.truth for one, k in zip(found, best, strict=True)], (0.0, 0.5, 0.6, 0.7, 0.8, 0.9, 0.99, 1.0))
