"""Probabilities over the verdict: the first effect, what could stand in its place, none and unknown."""

import math

import numpy as np

from . import tilt_source
from .calibration import further
from .machine.drawing import beside_drawing, shaped
from .outside.beside import Beyond
from .machine.pushes_back import pushes_away
from .calibration.stability import keep_their_size, survives
from .calibration.thresholds import (
    HALF,
    LOGIT_WIDTH,
    NEARLY_HALF,
    OF_NESTED,
    OPEN,
    PART,
    TIMES_AS_MUCH,
)

HOPELESS = 60.0  # twice the logarithm of the odds: a rival that has so much against it
LEAST_PROBABILITY = 1e-4  # below it an alternative is not worth a line
CONFUSABLE_ABOVE = 0.05


class Verdict:
    """`probabilities` is [(probability, effect, joint)], most probable first."""

    def __init__(self, probabilities, fit, open_share):
        kept = [p for p in sorted(probabilities, key=lambda p: -p[0]) if p[0] >= LEAST_PROBABILITY]
        total = sum(p[0] for p in kept)
        self.probabilities = [(p / total, effect, joint) for p, effect, joint in kept]
        self.fit, self.open_share = fit, open_share
        self.likeliest = {}  # (effect, joint): the likeliest fit with that effect, which stands last in it
        self.stable = None  # does it survive another low-pass? None where nothing is named, or that was not tried
        self.further = {}  # (effect, joint): probability of each effect after the first
        self.doubts = {}  # (effect, joint): why it is not surer, as words.DOUBTS has it
        self.beyond = None  # outside.beside.Beyond: what could stand there that is in no catalogue
        self.resembles = []  # [(probability, candidate)] of that

    def limit(self, most):
        """Further effects are no surer than `most`, {(effect, joint): (probability, why)}."""
        for key, sure in self.further.items():
            limit, why = most[key]
            self.further[key] = min(sure, limit)
            if sure > limit:
                self.doubts[key] = [*self.doubts.get(key, []), why]

    def doubted(self, at_most, why):
        """The same where the named effect may be what the sensors did, by what `why` says. What it loses goes to `none` and `unknown`
        alike, for nothing tells which of them it is."""
        first, effect, joint = self.probabilities[0]
        if first > at_most:
            self.doubts[effect, joint] = [why]
        over = max(first - at_most, 0.0)
        rest = {(e, j): p for p, e, j in self.probabilities[1:]}
        for no_cause in ("none", "unknown"):
            rest[no_cause, "none"] = rest.get((no_cause, "none"), 0.0) + 0.5 * over
        self.probabilities = sorted([(first - over, effect, joint), *((p, e, j) for (e, j), p in rest.items())], key=lambda p: -p[0])
        return self

    @property
    def effect(self):
        return self.probabilities[0][1]

    @property
    def joint(self):
        return self.probabilities[0][2]

    @property
    def names_a_cause(self):
        """Is an effect likelier than everything else together?"""
        return self.effect not in ("none", "unknown") and self.probabilities[0][0] >= HALF

    @property
    def known(self):
        """Probability that some effect of the catalogue is there: not that nothing is, nor something else."""
        return 1.0 - sum(p for p, effect, _ in self.probabilities if effect in ("none", "unknown"))

    def confusable(self):
        """Groups of (effects, joint, probability ratio) that this data does not tell apart."""
        named = self.probabilities[0]
        if named[1] in ("none", "unknown"):
            return []
        return [(p, effect, joint) for p, effect, joint in self.probabilities[1:]
                if p > CONFUSABLE_ABOVE and effect not in ("none", "unknown")][:3]  # fmt: skip


def logistic(x):
    return 1.0 / (1.0 + math.exp(-x))


def nothing_there(search, fit):
    """Probability that the chosen effects are none: by what the first gains alone, in its best form, beside replicates; else by what
    reconstruction usually leaves."""
    if search.calibration:
        return search.nothing(search.plain, search.reshaped(search.fit(fit.chosen[:1])))
    return too_little(search, fit) if sum(search.excess_by_kind(search.plain).values()) < search.tolerated else 0.0


def too_little(search, fit):
    """Probability that what was gained within the tolerance is no effect."""
    gain = (search.plain.excess - fit.excess) / search.detection_threshold
    return logistic((math.log(TIMES_AS_MUCH) - math.log(max(gain, 1e-9))) / LOGIT_WIDTH)


def remaining(search):
    """Probability that there is a gap, where no effect is found: by its size, and by what the best effect gains of it. Replicates say
    both; without them only the size counts, by what reconstruction usually leaves."""
    larger = math.log(search.gap_over_floor())
    if search.calibration:
        return 1.0 - min(search.calibration.nothing_left(larger), search.calibration.nothing_at_all())
    return logistic((larger - math.log(TIMES_AS_MUCH)) / LOGIT_WIDTH)


def no_effect(probability, gap_remains):
    """`none` and `unknown`, of the probability that no effect of the catalogue shows."""
    return [(probability * (1 - gap_remains), "none", "none"), (probability * gap_remains, "unknown", "none")]


def without_cause(search, nothing, unknown, gap_remains):
    """`none` and `unknown` beside chosen effects. What an effect leaves open is no gap where replicates leave as much."""
    if search.calibration:
        return no_effect(nothing + (1 - nothing) * unknown, gap_remains)
    return [(nothing, "none", "none"), ((1 - nothing) * unknown, "unknown", "none")]


def still_open(search, fit):
    """Share of the gap that is left: of all channels, or of those at the joint of the first effect, where it closes much of the whole.
    What nothing explains at another joint does not make it less sure."""
    dataset = search.dataset
    share, _ = open_at(search, fit, dataset.kinds)
    own = dataset.kinds_at(fit.chosen[0].joint)
    if own == dataset.kinds or share < HALF:
        return share
    at_joint, closed = open_at(search, fit, own)
    return min(at_joint, share) if closed > PART * search.above_floor(search.plain) else share


def open_at(search, fit, kinds):
    """(share of the chi-square in some kinds of channel that a fit leaves above what reconstruction leaves, what it closes there)."""
    before, after = search.excess_by_kind(search.plain), search.excess_by_kind(fit)
    closed = max(sum(before[kind] - after[kind] for kind in kinds), 0.0)
    left = search.above_floor(fit, kinds)
    return left / max(left + closed, 1.0), closed


class Odds:
    """What could stand in the first effect's place beside it. Every kind of channel has a likelihood temperature of its own: what a fine
    encoder shows of an approximate form says nothing about what a camera, or the torque, can tell apart."""

    def __init__(self, search, fit):
        self.search, self.fit = search, fit
        plain, self.mine = search.held_out_excess([]), search.held_out_excess(fit.chosen)
        self.temperature = {kind: search.temperature(x - search.tolerated_of[kind], plain[kind]) for kind, x in self.mine.items()}
        own = sum(self.mine[kind] for kind in search.dataset.kinds_at(fit.chosen[0].joint) if kind[0] == "T")
        self.nested_temperature = OF_NESTED * search.temperature(own)

    def _adds_nothing(self, other, theirs):
        """Do both fits together explain no more than the better one? Then that one holds the other, or is the true form."""
        more = [candidate for candidate in other.chosen if candidate not in self.fit.chosen]
        both = self.search.held_out_excess([*self.fit.chosen, *more])
        return min(sum(theirs.values()), sum(self.mine.values())) - sum(both.values()) < OF_NESTED * self.search.chance

    def of(self, other):
        """Likelihood of another fit beside that of the first."""
        theirs = self.search.held_out_excess(other.chosen)
        worse = sum((theirs[kind] - self.mine[kind]) / self.temperature[kind] for kind in theirs)
        if worse > HOPELESS:  # a lower temperature would not make it likelier
            return 0.0
        if self._adds_nothing(other, theirs):
            worse = (sum(theirs.values()) - sum(self.mine.values())) / self.nested_temperature
        return math.exp(-0.5 * max(worse, 0.0))


def rivals(search, fit):
    """The fit, and what could stand in its first effect's place; the nearest as well refined as that."""
    found = [other for other in search.scan(fit.chosen[1:]) if other.chosen[-1].key != fit.chosen[0].key]
    mine = search.fit([*fit.chosen[1:], fit.chosen[0]])
    every = [mine, *search.nearest_refined(found, len(mine.chosen) - 1, fit.excess)]
    temperature = search.temperature_of(fit)
    return [shaped(search, one, len(one.chosen) - 1, temperature) if one.excess < HOPELESS * temperature + mine.excess else one for one in every]


def other_sets(search, fit):
    """Whole sets of as many effects that came near the fit without its first one; their own first effect stands last, as a rival's
    does. What follows was chosen to suit the first effect, and a rival that suits others is seen beside those alone. Sets that
    differ from the fit in one effect are among the rivals already."""
    beside = {candidate.key for candidate in fit.chosen[1:]}
    found = []
    for one in search.other_sets:
        keys = {candidate.key for candidate in one.chosen}
        if len(one.chosen) == len(fit.chosen) and fit.chosen[0].key not in keys and len(keys - beside) > 1:
            found.append(search.ordered(one))
    return [search.fit([*one.chosen[1:], one.chosen[0]]) for one in found]


def shares(search, fit, others, sets=()):
    """Probability of each of the `rivals`, and of each of the `other_sets`, if one of them has the first effect."""
    odds, without = Odds(search, fit), search.fit(fit.chosen[1:])
    weight = [o.chosen[-1].weight(o.strengths[-1]) * odds.of(o) * (1 - search.nothing(without, o)) for o in others]
    beside = _weight(without)
    weight += [_weight(o) / beside * odds.of(o) * (1 - search.nothing(search.fit(o.chosen[:-1]), o)) for o in sets]
    likely = [k for k, w in enumerate(weight) if w > 0]
    seen = np.array([witness(search, [*others, *sets][k], search.temperature_of(fit)) for k in likely])
    out = np.zeros(len(weight))
    out[likely] = np.array(weight)[likely] * np.exp(seen - max(seen, default=0.0))
    return out / (float(np.sum(out)) or 1.0)


def witness(search, fit, temperature):
    """Logarithm of how likely what the torques do not say is beside a fit: the camera's mean, and that the machine is as it is drawn."""
    return tilt_source.witness(search, fit) - 0.5 * search.off_drawing(fit, temperature)


def _weight(fit):
    """How likely its effects' forms are before the data."""
    return math.prod(candidate.weight(strengths) for candidate, strengths in zip(fit.chosen, fit.strengths, strict=True))


def judge(search, fit, other=None, around=(), fixed=True):
    """The verdict on a search's outcome, and the fit with the named effect in front. `other` makes the dataset through another
    low-pass, at which a named effect must show as well; `around` makes those at which it must have the same size where that cannot be
    tried. `fixed`: do the sensors leave the inertia known? None: they take more of it than they leave."""
    verdict = first_judgement(search, fit, bool(fixed) and not around)
    if not verdict.fit.chosen:
        return verdict
    elsewhere = other() if other else None
    further.judged(search, verdict, elsewhere)
    if verdict.beyond:
        verdict.beyond.add_to(verdict)
    steady = keep_their_size(search, verdict.fit, [one() for one in around]) if around else {c.key for c in verdict.fit.chosen}
    most = {c.key: at_most(search, verdict.fit, c, fixed) if c.key in steady else (NEARLY_HALF, "lowpass") for c in verdict.fit.chosen}
    verdict.limit(most)
    if verdict.effect == "unknown":
        return verdict
    first = verdict.fit.chosen[0]
    if other or around:
        verdict.stable = survives(search, verdict.fit, verdict.rivals, elsewhere) if other else first.key in steady
    verdict.doubted(*((NEARLY_HALF, "lowpass") if verdict.stable is False else most[first.key]))
    return with_named_in_front(search, verdict)


def with_named_in_front(search, verdict):
    """A verdict whose fit is that of what is named now: of no effect, or of a rival that a doubt about the first has left in front.
    Effects that only this rival's fit has come without a probability of their own, and none is said with confidence."""
    named = (verdict.effect, verdict.joint)
    if verdict.effect in ("none", "unknown"):
        verdict.fit = search.plain
    elif named != verdict.fit.chosen[0].key:
        verdict.fit = in_front(search, verdict.likeliest[named])
        verdict.doubts |= {c.key: ["unjudged"] for c in verdict.fit.chosen[1:] if c.key not in verdict.further}
        verdict.further = {c.key: verdict.further.get(c.key, NEARLY_HALF) for c in verdict.fit.chosen[1:]}
    return verdict


def in_front(search, fit):
    """The same fit with its last effect, the one that it was made for, as its first."""
    return search.fit([fit.chosen[-1], *fit.chosen[:-1]])


def at_most(search, fit, one, fixed):
    """(how probable one effect of a fit can be, why it is no more), for what the readings alone may gain. Where they leave the inertia
    unknown the effect may stand for that, and must gain more than anything gains in replicates; where most of it is lost, these tell too
    little. Nor is an effect sure where without any no more than the noise is left, nor a spring that pushes away."""
    calibration = search.calibration
    if calibration and calibration.outdone():
        return NEARLY_HALF, "replicates"
    if search.is_within_noise():
        return NEARLY_HALF, "noise"
    if search.dataset.effects[one.effect].stiffness and pushes_away(*beside_drawing(search, fit), one.key):
        return NEARLY_HALF, "pushes"
    if fixed:
        return 1.0, None
    if fixed is None or not calibration:
        return NEARLY_HALF, "inertia"
    return 1.0 - calibration.by_readings(search.fit([c for c in fit.chosen if c is not one]).excess - fit.excess), "inertia"


def first_judgement(search, fit, sound):
    """The same at the low-pass of the search."""
    gap_remains, beyond = remaining(search), Beyond(search, fit, sound)
    if not fit.chosen:
        gap_remains = max(gap_remains, beyond.probability)
        verdict = Verdict(no_effect(1.0, gap_remains), fit, 1.0 if gap_remains > 0.5 else 0.0)
        verdict.resembles = beyond.instead()
        return verdict
    open_share = still_open(search, fit)
    unknown = logistic((math.log(max(open_share, 1e-4)) - math.log(OPEN)) / LOGIT_WIDTH)
    unknown = max(unknown, beyond.probability)
    others, sets = rivals(search, fit), other_sets(search, fit)
    nothing = nothing_there(search, fit)
    probabilities, likeliest = _by_effect(shares(search, fit, others, sets), [*others, *sets])
    no_cause = without_cause(search, nothing, unknown, gap_remains)
    verdict = Verdict([*((p * (1 - unknown) * (1 - nothing), *key) for key, p in probabilities.items()), *no_cause], fit, open_share)
    verdict.rivals, verdict.beyond, verdict.resembles = [*others, *sets], beyond, beyond.instead()
    verdict.likeliest = likeliest
    imitates = open_share > OPEN or beyond.probability > HALF
    if verdict.effect == "none" or (verdict.effect == "unknown" and imitates):
        verdict.fit = search.plain
        return verdict
    named = (verdict.effect, verdict.joint)
    if named in likeliest and likeliest[named].chosen[-1] is not fit.chosen[0]:  # a simpler effect or form does as well as the one that fits best
        verdict.fit = in_front(search, likeliest[named])
    return verdict


def _by_effect(probabilities, fits):
    """({key: probability}, {key: likeliest fit}) of the effect that stands last in each fit."""
    summed, likeliest = {}, {}
    for probability, fit in sorted(zip(probabilities, fits, strict=True), key=lambda pair: -pair[0]):
        key = fit.chosen[-1].key
        summed[key] = summed.get(key, 0.0) + float(probability)
        likeliest.setdefault(key, fit)
    return summed, likeliest
