"""Many toys, each searched and judged by talus-gap's own code beside what is true of it."""

from dataclasses import dataclass

import numpy as np

from talus.diagnosis import figures, verdict
from talus.diagnosis.calibration import thresholds

from . import exact
from .toy import BANDWIDTH, SAMPLES, SIGMA_NM, Problem, searched, unit_rows

EFFECTS, OUTSIDE = 6, -1
LEAST_STEP = thresholds.TIMES_AS_MUCH * 2 * np.log(EFFECTS)  # chi-square that the search takes for an effect
ROUGH_GAINS = (20.0, 400.0)  # chi-square that an effect gains of its own part of what reconstruction leaves, each size as likely as the next
DRAWS = 400
LOSS = 2.0  # chi-square by which a useless column's gain on held-out blocks is less than in its own fit


@dataclass
class Trial:
    """What was true (the number of an effect, OUTSIDE or None), and what came out."""

    truth: int | None
    taken: list  # numbers of the effects that the search takes
    named: str  # verdict
    none: float  # probabilities of the verdict
    unknown: float
    covered: bool | None  # does the interval hold the strength of the effect that is taken rightly, alone?
    promise: float  # chance that something is taken where nothing is hidden: what the formula comes to with the true widths


def number_of(key):
    return int(key[0].removeprefix("effect_"))


def problem(random, rough, alike=0.8, spread=0.3):
    """With gains that reconstruction leaves to each effect, or in white noise alone."""
    levels = np.exp(random.uniform(*np.log(ROUGH_GAINS), EFFECTS)) if rough else None
    return Problem(random, EFFECTS, alike, levels, spread, thresholds.MISFIT)


def chance(toy):
    """What the best effect gains by chance, of noise and of what reconstruction leaves."""
    left = toy.beside_base(toy.rough_draws(toy.random, DRAWS) @ toy.effects) / SIGMA_NM
    return 2 * np.log(EFFECTS) * (1 + np.mean(np.sum(left**2, axis=1)) / (SAMPLES * BANDWIDTH))


def nulls(toy, floor):
    """(mean, width) of the logarithm of each effect's gain, and a floor, where nothing is hidden, of many draws."""
    shown = toy.random.standard_normal((DRAWS, EFFECTS)) + toy.rough_draws(toy.random, DRAWS) @ toy.shown_by_effects
    logs = np.log(np.maximum(shown**2 - LOSS, 0) + floor)
    return logs.mean(0), np.hypot(logs.std(0), toy.misfit)


def hidden_strengths(toy, roughness_Nm, k):
    """Strengths with one effect, whose gain is as the method's prior has it: ln(gain + floor) anywhere in a range above the nulls'."""
    floor = chance(toy)
    middle, width = (x[k] for x in nulls(toy, floor))
    above = width * (thresholds.DEVIATIONS + toy.random.standard_normal()) + thresholds.RANGE * toy.random.uniform()
    gain = max(np.exp(middle + above) - floor, 0.0)
    already = toy.shown(roughness_Nm)[k]
    root = np.copysign(np.sqrt(gain), already) - already
    return np.where(np.arange(EFFECTS) == k, root * toy.unit_Nm[k], 0.0)


def outside_Nm(toy):
    """A torque that no effect explains, anything from one least step of chi-square to a thousand."""
    row = toy.beside_base(unit_rows(toy.random.standard_normal(SAMPLES)))
    gain = LEAST_STEP * np.exp(thresholds.RANGE * toy.random.uniform())
    return row * np.sqrt(gain / np.sum(row**2)) * SIGMA_NM


def drawn_truth(random, outside):
    """With one half nothing, with the probability `outside` what is in no catalogue, else one of the effects, each as likely."""
    place = random.uniform()
    return None if place < 0.5 else OUTSIDE if place < 0.5 + outside else int(random.integers(EFFECTS))


def from_the_prior(random, rough, outside=0.0, spread=0.3, something=True):
    """One trial, of drawn_truth() or where nothing is hidden."""
    toy = problem(random, rough, spread=spread)
    roughness_Nm = toy.roughness()
    truth = drawn_truth(random, outside) if something else None
    roughness_Nm = roughness_Nm + (outside_Nm(toy) if truth == OUTSIDE else 0.0)
    strengths = hidden_strengths(toy, roughness_Nm, truth) if truth in range(EFFECTS) else np.zeros(EFFECTS)
    search, fit = searched(toy, toy.recording(strengths, roughness_Nm))
    taken = [number_of(c.key) for c in fit.chosen]
    judged, covered = verdict.judge(search, fit), holds(search, fit, strengths[truth]) if taken == [truth] else None
    of = {effect: p for p, effect, _ in judged.probabilities}
    promise = exact.taken_by_chance(nulls(toy, chance(toy))[1], thresholds.DEVIATIONS, thresholds.RANGE) if truth is None else 0.0
    return Trial(truth, taken, judged.effect, of.get("none", 0.0), of.get("unknown", 0.0), covered, promise)


# ---- intervals ---------------------------------------------------------------------------


@dataclass
class Measured:
    """An effect's strength as measured."""

    deviations: float  # of its true strength, in standard deviations of its estimate by theory
    half_width: float  # of the interval, in the same
    covered: bool
    taken: bool  # does the search take this effect and no other?


def holds(search, fit, strength_Nm):
    """Does the reported interval of the one effect hold its true strength?"""
    low, high = figures.interval(fit.chosen[0], fit.strengths[0], figures.whole_errors(search, fit)[0])["strength_Nm"]
    return bool(low <= strength_Nm <= high)


def measured(random, least=4.0, most=12.0):
    """A toy with one effect of a known strength, in white noise; without replicates, for intervals do not ask for them."""
    toy, k = problem(random, rough=False), int(random.integers(EFFECTS))
    deviations = float(random.uniform(least, most))
    strength_Nm = deviations * toy.unit_Nm[k]
    search, found = searched(toy, toy.recording(strength_Nm * (np.arange(EFFECTS) == k)), replicated=False)
    fit = search.fit([toy.candidates[k]])
    half_width = 1.96 * figures.whole_errors(search, fit)[0][0] / toy.unit_Nm[k]
    return Measured(deviations, half_width, holds(search, fit, strength_Nm), [c.key for c in found.chosen] == [toy.candidates[k].key])


# ---- which effect it is ------------------------------------------------------------------

LARGE = 30.0  # standard deviation of the true strength, in strengths that gain 1
UNLIKE = (0.001, 0.3)  # one less the correlation of the effects that are alike


@dataclass
class Choice:
    """Probabilities of all effects where one of them is taken, as logarithms."""

    truth: int
    exact: np.ndarray
    shares: np.ndarray
    temperature: float  # that theory expects the shares to have


def choice(random):
    """One effect with a normally distributed strength, among others of which each is like another one; None where not just one is taken."""
    toy, truth = problem(random, rough=False, alike=1 - np.exp(random.uniform(*np.log(UNLIKE)))), int(random.integers(EFFECTS))
    sizes_Nm = LARGE * toy.unit_Nm
    reading = toy.recording(sizes_Nm * random.standard_normal() * (np.arange(EFFECTS) == truth))
    search, fit = searched(toy, reading)
    if len(fit.chosen) != 1:
        return None
    others, found = verdict.rivals(search, fit), np.zeros(EFFECTS)
    for share, other in zip(verdict.shares(search, fit, others, verdict.other_sets(search, fit)), others, strict=True):
        found[number_of(other.chosen[-1].key)] += share
    with np.errstate(divide="ignore"):
        return Choice(truth, exact.posterior(toy, reading, sizes_Nm), np.log(found), verdict.Odds(search, fit).nested_temperature)
