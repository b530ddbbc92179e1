"""Which effects: greedy over all candidates with a beam, every step judged on held-out blocks."""

import contextlib
import copy
import functools
import gc
import itertools
import math

import numpy as np

from . import irregular
from .calibration.gains import Replicator
from .catalogue import sparse
from .catalogue.candidate import joined
from .catalogue.ripple import are_apart
from .effects import candidates, torque_constant_error
from .figures import Residuals
from .gram import Gram
from .motion import has_inertia
from .torque_terms import Extent, TorqueTerms
from .shapes import REFINED_WITHIN, ROUGH_OF_SIGNAL, refined
from .calibration.thresholds import (
    DEVIATIONS,
    HALF,
    NEARLY_HALF,
    PART,
    REST_AS_NOISE,
    RIGHT_TO,
    TIMES_AS_MUCH,
    TOLERATED_PER_FREEDOM,
)

BEAM = 3
MOST_JOINED = 4
PROMISING = 0.2  # of the best gain in a first look: less, and the shapes of a body to be stepped stay few
REFINED = 3  # of the best effects, between the grid's shapes


class Fit:
    """A set of candidates fitted together."""

    def __init__(self, chosen, excess, strengths=()):
        self.chosen, self.excess, self.strengths = list(chosen), excess, strengths

    def last_moved(self, place):
        """The same fit with its last candidate at another place."""

        def moved(every):
            *others, last = every
            return [*others[:place], last, *others[place:]]

        return Fit(moved(self.chosen), self.excess, moved(self.strengths))

    def added_to(self, before):
        """The same fit, what is not among the effects of another one last."""
        there = {c.key for c in before.chosen}
        order = sorted(range(len(self.chosen)), key=lambda place: self.chosen[place].key not in there)
        return Fit([self.chosen[k] for k in order], self.excess, [self.strengths[k] for k in order])

    def is_physical(self, looking=False):
        """Are strengths within what there can be, or at least what leads there?"""
        return all(c.within_range(s, looking) for c, s in zip(self.chosen, self.strengths))


class Search:
    """Candidates at identified base parameters, and the fits among them."""

    def __init__(self, dataset, base, choose=list, excess=0.0):
        self.dataset = dataset
        self.all_terms = [TorqueTerms(dataset, record, base, excess) for record in range(len(dataset.processed_recordings))]
        self.extent = Extent(self.all_terms)
        self.gram = Gram(dataset, self.all_terms, choose(candidates(dataset, self.all_terms, self.extent)))
        self.freedom = dataset.freedom()
        self.chance = 2.0 * math.log(max(len(self.gram.candidates), 2))  # what the best of so many columns gains in white noise
        self.detection_threshold = TIMES_AS_MUCH * self.chance
        self.plain = self.fit([])
        # what reconstruction itself may leave
        self.tolerated_of = {kind: TOLERATED_PER_FREEDOM * dataset.freedom(kind) for kind in dataset.kinds}
        self.tolerated = sum(self.tolerated_of.values())
        self.rough = self.tolerated + ROUGH_OF_SIGNAL**2 * self._signal()  # shapes between the grid's do not mend so much
        self.floor_of = dict(self.tolerated_of)  # what may be left where nothing is hidden
        self.replicator = self.calibration = None
        self.camera_zero_rad = None  # how well the camera's zero is known against the bench; None: not at all
        self._irregular = {}
        self.with_outsiders = None  # the fit where causes outside the catalogue may stand as well; None: none of them shows
        self.outside_alone = []  # fits with one such cause alone, best first
        self._scanned = (False,)  # whether causes outside the catalogue are looked for, effects, or both
        self.other_sets = []  # fits with as many effects as the chosen one, that came near it
        self.further = {}  # (effect, joint) of each further effect: probability that it is nothing

    def calibrate(self, replicator):
        """What reconstruction leaves is as much as it leaves in replicates, where that is more."""
        self.replicator, self.calibration = replicator, replicator.beside(self, self.plain)
        for kind, excess in (self.calibration.excess if self.calibration else {}).items():
            self.floor_of[kind] = max(self.floor_of[kind], excess)

    def held_out_excess(self, chosen):
        """{kind: chi-square over its freedom that candidates leave on held-out blocks}."""
        blocks = self.gram.held_out_blocks(self.columns(chosen))
        return {kind: values.sum() - self.dataset.freedom(kind) for kind, values in blocks.items()}

    def excess_by_kind(self, fit):
        """The same of a fit, with what does not repeat with the motion."""
        apart = self.irregular(fit)
        return {kind: x + apart.get(kind, 0.0) for kind, x in self.held_out_excess(fit.chosen).items()}

    def irregular(self, fit):
        """{kind: chi-square of what does not repeat with the motion} beside a fit."""
        key = tuple((c.key, c.shape) for c in fit.chosen)
        if key not in self._irregular:
            self._irregular[key] = irregular.excess(self.dataset, Residuals(self, fit.chosen))
        return self._irregular[key]

    def is_within_noise(self):
        """Does the plain model leave no more than the noise, in every kind of channel?"""
        return bool(max(self.excess_by_kind(self.plain).values()) <= 0.0)

    def above_floor(self, fit, kinds=None):
        """Chi-square that a fit leaves above what reconstruction leaves, of all kinds of channel or some together."""
        found = self.excess_by_kind(fit)
        return max(sum(found[kind] - self.floor_of[kind] for kind in kinds or found), 0.0)

    def gap_over_floor(self):
        """What the plain model leaves, over what reconstruction leaves. A kind of channel that is below its floor does not hide
        what another shows; what lasts in one is no noise, however little of the whole it is."""
        found, floor = self.excess_by_kind(self.plain), self.floor_of
        whole = sum(max(found[kind], floor[kind]) for kind in floor) / sum(floor.values())
        return max([whole, *(found[kind] / floor[kind] for kind, lasts in self.irregular(self.plain).items() if lasts)])

    def off_drawing(self, fit, temperature):
        """Chi-square by which the machine beside a fit's effects is not the one of the model file, the data's taken at a likelihood
        temperature."""
        return self.gram.off_drawing(self.columns(fit.chosen), temperature)

    def as_drawn(self, temperature):
        """The same search where the model file is a drawing, with likelihood temperature of the data."""
        near = copy.copy(self)
        near.gram, near._irregular = self.gram.as_drawn(temperature), {}
        return near

    def farthest_off_drawing(self, fit):
        """(name, times the model file's value) of the parameter of inertia or gravity that is farthest from it beside a fit's effects."""
        dataset = self.dataset
        base = self.base_of(fit.chosen)
        far = int(np.argmax(np.abs(base - dataset.prior) / dataset.drawn_width))
        return list(dataset.model.base)[far], float(base[far] / dataset.prior[far])

    def temperature(self, left, before=0.0):
        """By how much chi-square differs between forms that are equally good: by chance, and the more is left, and was there `before`, the
        more."""
        return self.chance + REST_AS_NOISE * max(left, 0.0) + RIGHT_TO**2 * max(before, 0.0)

    def temperature_of(self, fit):
        """The same over all channels, beside a fit."""
        return self.temperature(fit.excess - self.tolerated, self.plain.excess)

    def is_outside(self, key):
        """Is an (effect, joint) in no catalogue?"""
        return self.dataset.effects[key[0]].outside

    def _is_scanned(self, candidate, taken):
        return candidate.key not in taken and self.is_outside(candidate.key) in self._scanned

    @contextlib.contextmanager
    def with_outside(self, effects_too=True):
        """Causes outside the catalogue are looked for, beside effects or alone."""
        before, self._scanned = self._scanned, (False, True) if effects_too else (True,)
        try:
            yield
        finally:
            self._scanned = before

    def nothing(self, before, after):
        """Probability that what a step from one fit to another gains is nothing; 0 where there are no replicates."""
        return self.calibration.nothing_of(before, after) if self.calibration else 0.0

    def _signal(self):
        """Chi-square of the measured torques themselves."""
        return sum(float(c.values[c.rows] @ c.values[c.rows]) / self.dataset.sigma[c.kind] ** 2
                   for c in self.dataset.channels if c.kind[0] == "T")  # fmt: skip

    def columns(self, chosen):
        return [column for candidate in chosen for column in candidate.columns]

    def fit(self, chosen):
        """The excess over noise that these candidates leave on held-out blocks, and each one's strengths."""
        return self._fit(chosen, *self.gram.held_out(self.columns(chosen)))

    def _fit(self, chosen, chi2, strengths):
        rest, own = list(strengths), []
        for candidate in chosen:
            own.append([rest.pop(0) for _ in candidate.columns])
        return Fit(chosen, chi2 - self.freedom, own)

    def beside(self, chosen, candidates, looking=False, limits=True):
        """Fits of each candidate beside the chosen ones; those out of physical range are left out, if there are `limits`."""
        found = self.gram.scan(self.columns(chosen), candidates)
        fits = [self._fit([*chosen, c], *one) for c, one in zip(candidates, found)]
        return [fit for fit in fits if not limits or fit.is_physical(looking)]

    def scan(self, chosen, looking=False, limits=True):
        """The best shape of every (effect, joint) beside the chosen ones, best first."""
        best, taken = {}, {c.key for c in chosen}
        for fit in self.beside(chosen, [c for c in self.gram.candidates if self._is_scanned(c, taken)], looking, limits):
            key = fit.chosen[-1].key
            if key not in best or fit.excess < best[key].excess:
                best[key] = fit
        ranked = sorted(best.values(), key=lambda fit: fit.excess)
        for place, fit in enumerate(ranked[:MOST_JOINED]):
            ranked[place] = self._joined(fit)
        return sorted(ranked, key=lambda fit: fit.excess)

    def _joined(self, fit):
        """Effects of several orders or modes get a second one, where it closes much of what the first leaves."""
        *others, last = fit.chosen
        within = fit.excess < self.tolerated
        if not self.dataset.effects[last.effect].several or (within and self.dataset.at_motor):
            return fit
        shapes = [c for c in self.gram.candidates if c.key == last.key and not set(c.columns) & set(last.columns)]
        shapes = [c for c in shapes if len(c.columns) <= len(last.columns) and are_apart(last, c)]
        found = self.beside(others, [joined(last, c) for c in shapes])
        second = min(found, key=lambda f: f.excess, default=fit)
        # a second order that hides within the tolerance must be as plain as an effect that does
        least = TIMES_AS_MUCH * self.detection_threshold if within else self.detection_threshold
        return second if fit.excess - second.excess > max(PART * (fit.excess - self.tolerated), least) else fit

    def reshaped(self, fit):
        """Each chosen effect's shape looked for anew beside the others."""
        for i, old in enumerate(fit.chosen):
            others = [*fit.chosen[:i], *fit.chosen[i + 1:]]
            for found in self.beside(others, [c for c in self.gram.candidates if c.key == old.key]):
                if found.excess < fit.excess - 1e-9:
                    fit = found.last_moved(i)
        return fit

    def all_refined(self, fit):
        """Every effect's shape, the last one's first: it has only been looked for on the grid."""
        for place in reversed(range(len(fit.chosen))):
            fit = refined(self, fit, place)
        return fit

    def singles(self):
        """The best shape of every (effect, joint), best first, the first few between the grid's."""
        found = self.scan([])
        if not found:
            return []
        found = self.nearest_refined(found, 0, found[0].excess)
        led = {fit.chosen[0].key: fit for fit in self.led_to([], found[0].excess)}
        rest = [fit for fit in found if fit.chosen[0].key not in led or fit.excess < led[fit.chosen[0].key].excess]
        return sorted([*rest, *led.values()], key=lambda fit: fit.excess)

    def base_of(self, chosen):
        """Base parameters fitted with these candidates, to all blocks."""
        return self.gram.fold_strengths(self.columns(chosen))[-1][:self.dataset.bases]

    def bases_beside(self):
        """Base parameters that a machine can have beside one effect, of the few that close most: what is not in the model can turn its
        inertia negative, or make it a machine that does not move as it was recorded."""
        every = (self.base_of(fit.chosen) for fit in self.scan([], looking=True))
        return itertools.islice((base for base in every if has_inertia(self.dataset, base)), BEAM)

    def led_to(self, chosen, best):
        """While much is left: fits with one more effect, of each (effect, joint) the one that is found downhill from the best
        of those shapes that are too little of an effect as they stand."""
        much, taken = REFINED_WITHIN * self.rough, {c.key for c in chosen}
        some = [c for c in self.gram.candidates if c.begin_low and self._is_scanned(c, taken)]
        if best < much or not some:
            return []
        starts = {}
        for fit in self.beside(chosen, some, looking=True):
            key = fit.chosen[-1].key
            if key not in starts or fit.excess < starts[key].excess:
                starts[key] = fit
        near = [fit for fit in starts.values() if not fit.is_physical() and self._may_come_near(fit, len(chosen), best)]
        return [end for fit in near if (end := refined(self, fit, len(chosen))).is_physical()]

    def nearest_refined(self, found, place, best):
        """Ranked fits, the effect at `place` of the first few between the grid's shapes if they come near the `best` excess, or are
        of a body that may only be out of step; ranked again."""
        first = [refined(self, fit, place) if self._may_come_near(fit, place, best) else fit for fit in found[:REFINED]]
        return sorted([*first, *found[REFINED:]], key=lambda fit: fit.excess)

    def _may_come_near(self, fit, place, best):
        """A spring that swings a little too fast closes a part of what the right one would."""
        if fit.excess < REFINED_WITHIN * max(best, self.rough):
            return True
        if not self.dataset.effects[fit.chosen[place].effect].integrated:
            return False
        without = self.fit([*fit.chosen[:place], *fit.chosen[place + 1:]]).excess
        return without - fit.excess > PROMISING * (without - best)

    def step(self, before, after):
        """What a step from one fit to another gains: (tempered gain, deviations over the blocks, share closed of what
        stood open where the new effect shows)."""
        old, new = (self.gram.held_out_blocks(self.columns(fit.chosen)) for fit in (before, after))
        total_old, total_new = sum(old.values()), sum(new.values())
        filled = total_old > 0
        gain, record = (total_old - total_new)[filled], self.dataset.block_record[filled]
        # where blocks differ much in size, the sum is one block's word: relative gains give each block its own
        z = max(over_blocks(gain, record), over_blocks(gain / (total_old + total_new)[filled], record))
        tempered = (before.excess - after.excess) / max(1.0, (after.excess + self.freedom) / self.freedom)
        own = self._tempered_at(self.dataset.kinds_at(after.chosen[-1].joint), old, new)
        return max(tempered, own), z, self._share(before, after, old, new)

    def _tempered_at(self, kinds, old, new):
        """The gain of some kinds of channel, over what is left of each degree of their freedom."""
        before, after = (sum(x[kind].sum() for kind in kinds) for x in (old, new))
        return (before - after) / max(1.0, after / sum(self.dataset.freedom(kind) for kind in kinds))

    def _share(self, before, after, old, new):
        """Share of the open excess that a step closes, over all channels, those at the added effect's joint, or its torque
        alone: what another effect leaves elsewhere says nothing about this one."""
        shares = []
        for kinds in self.dataset.scopes_at(after.chosen[-1].joint):
            left, then = (sum(x[kind].sum() for kind in kinds) for x in (old, new))
            still_open = left - sum(self.dataset.freedom(k) + self.floor_of[k] for k in kinds)
            closed = left - then
            if still_open <= self.detection_threshold:  # all that stands open does not repeat with the motion
                apart, rest = (sum(self.irregular(fit).get(kind, 0.0) for kind in kinds) for fit in (before, after))
                still_open, closed = still_open + apart, closed + apart - rest
            shares.append(closed / still_open if still_open > 0 else 0.0)
        return max(shares)

    def significant(self, before, after, share, steps=1.0):
        """Is the step from one fit to another worth an effect? `share` of what is left must be closed, and the gain be worth
        some least steps."""
        tempered, z, closed = self.step(before, after)
        enough = tempered > steps * self.detection_threshold and z > DEVIATIONS
        return bool(enough and (share == 0 or closed > share) and self.nothing(before, after) < HALF)

    def is_worth_adding(self, before, after):
        """Is the further effect of `after` more than what another form of the effect at its joint would do?"""
        after = after.added_to(before)
        return self._is_beyond_forms(before, after.chosen[-1]) and self.significant(before, after, NEARLY_HALF, TIMES_AS_MUCH)

    def _is_beyond_forms(self, before, candidate):
        """Does more stand open where a candidate acts than other forms of the effects there may leave: over all channels, those at
        its joint, or its torque alone? Channels below their noise do not hide what another one shows."""
        shaped = [c for c in before.chosen if self._has_other_forms(c) and is_near(c, candidate)]
        without, there = (self.held_out_excess(chosen) for chosen in ([c for c in before.chosen if c not in shaped], before.chosen))
        # what does not repeat with the motion counts: friction that drifts may be in the noise otherwise
        left = self.excess_by_kind(before)
        return any(sum(left[kind] - self.tolerated_of[kind] for kind in kinds) >= RIGHT_TO * sum(without[kind] - there[kind] for kind in kinds)
                   for kinds in self.dataset.scopes_at(candidate.joint))  # fmt: skip

    def _has_other_forms(self, candidate):
        """A wrong constant has none."""
        return sum(c.key == candidate.key for c in self.gram.candidates) > 1

    def is_nothing(self, before, after):
        """Is what a further effect gains likely nothing, by replicates that have the effects before it?"""
        calibration = self.replicator and self.calibration and self.replicator.beside(self, before)
        probability = calibration.nothing_of(before, after) if calibration else self.nothing(before, after)
        there = {c.key for c in before.chosen}
        self.further = self.further | {c.key: probability for c in after.chosen if c.key not in there}
        return probability > HALF

    def something_alone(self):
        """Single effects, best first, that are likelier something than nothing; none where the best is not worth an effect."""
        singles = [fit for fit in self.singles() if self.nothing(self.plain, fit) < HALF]
        return singles if singles and self.significant(self.plain, singles[0], 0.0) else []

    def look_outside(self, singles):
        """The same search with causes outside the catalogue, where one of them shows alone, beside the catalogue's `singles`. Not without
        replicates: rough forms take up what anything leaves."""
        if not self.calibration:
            return
        with self.with_outside(effects_too=False):
            self.outside_alone = outside = [fit for fit in self.something_alone() if self.significant(self.plain, fit, 0.0)]
        if not outside:
            return
        further, sets = self.further, self.other_sets
        with self.with_outside():
            found = self.extended(sorted([*singles, *outside], key=lambda fit: fit.excess))
        self.with_outsiders = found if any(self.is_outside(c.key) for c in found.chosen) else None
        self.further, self.other_sets = further, sets

    def extended(self, singles):
        """One to three effects, from the ranking of single ones."""
        best = singles[0]
        if not self._worth_more(best):
            return best
        pairs = self._near_refined(self._followed(singles[:BEAM]))
        if not pairs:
            return best
        led = [self.all_refined(self.reshaped(fit)) for fit in self._something(best, self.led_to(best.chosen, pairs[0].excess))]
        second, *others = sorted([*pairs, *led], key=lambda fit: fit.excess)
        if not self._is_taken(best, second):
            near, others = [second, *others], []
            second = self._another(best, self._something(best, self.scan(best.chosen))[:BEAM])
            if second is None:
                return self._together(best, near)
        self.other_sets = others
        if self._worth_more(second) and (third := self._something(second, self.scan(second.chosen))):
            if self._is_taken(second, third[0]):
                third, *self.other_sets = self._near_refined([third[0], *self._followed(others)], reshape=False)
                return self._with_worthy_last(third, second)
            if another := self._another(second, third[1:BEAM]):
                return self._with_worthy_last(another, second)
        return self._with_worthy_last(second, best)

    def _is_taken(self, before, after):
        """Is the further effect worth adding, and likelier something than nothing?"""
        return self.is_worth_adding(before, after) and not self.is_nothing(before, after)

    def _another(self, before, found):
        """Of ranked sets with one effect more the first that is taken, where the one that closes most is not; or None."""
        for near in found:
            if self.is_worth_adding(before, near):
                fit = self.all_refined(self.reshaped(near))
                if self._is_taken(before, fit):
                    return fit
        return None

    def _together(self, best, pairs):
        """Two effects that hide each other close little one by one: of the sets with one effect more than `pairs`, none of which is taken, the one
        that leaves least, if each of its effects is worth adding to the others; else `best`. What is not worth it on the grid is not refined."""
        followed = [fit for fit in self._followed(pairs) if all(self.is_worth_adding(self._without(fit, one), fit) for one in fit.chosen)]
        found = self._near_refined(followed) if followed else []
        if not found or not all(self._is_worthy(found[0], one) for one in found[0].chosen):
            return best
        self.other_sets = found[1:]
        return self.ordered(found[0])

    def _is_worthy(self, fit, one):
        """Is an effect of a set worth adding to the others in their best forms, and likelier something than nothing?"""
        return self._is_taken(self.all_refined(self.reshaped(self._without(fit, one))), fit)

    def _without(self, fit, one):
        """A set without one of its effects, the others' shapes as they are."""
        return self.fit([c for c in fit.chosen if c is not one])

    def _with_worthy_last(self, fit, before):
        """A set of effects in its order, without its last one where that is not worth adding to the others in their best forms: what
        was found first may be what they explain better. `before`: what the set was found beside, and worth more than."""
        fit = self.ordered(fit)
        others = self.fit(fit.chosen[:-1])
        as_before = {c.key for c in others.chosen} == {c.key for c in before.chosen} and others.excess >= before.excess
        if as_before or not others.chosen:
            return fit
        others = self.all_refined(self.reshaped(others))
        if self._is_taken(others, fit):
            return fit
        return self._with_worthy_last(others, self.plain)

    def _followed(self, starts):
        """Each fit with the further effect that closes most beside it."""
        return [found[0] for start in starts if (found := self._something(start, self.scan(start.chosen)))]

    def _near_refined(self, fits, reshape=True):
        """Sets of effects, each once, those that come near the best with their shapes between the grid's; best first."""
        once = {}
        for fit in sorted(fits, key=lambda fit: fit.excess):
            once.setdefault(frozenset(c.key for c in fit.chosen), fit)
        near = [fit for fit in once.values() if fit.excess < REFINED_WITHIN * max(min(f.excess for f in fits), self.rough)]
        found = [self.all_refined(self.reshaped(fit) if reshape else fit) for fit in near]
        return sorted(found, key=lambda fit: fit.excess)

    def _something(self, before, found):
        """Of fits with one more effect those whose gain is not what replicates have, too: behind it another may stand."""
        return [fit for fit in found if self.nothing(before, fit) < HALF]

    def _worth_more(self, fit):
        """Is there a kind of channel in which enough stands open? A fine encoder's gap can dwarf the others'. What does not come back
        with the motion counts: friction that drifts is noise otherwise."""
        left = self.excess_by_kind(fit)
        return any(left[kind] - self.floor_of[kind] > self.detection_threshold for kind in self.dataset.kinds)

    def ordered(self, fit):
        """The effect without which the rest, in its best forms, is worst comes first."""
        without = [self.reshaped(self.fit([c for c in fit.chosen if c is not one])).excess for one in fit.chosen]
        return self.fit([fit.chosen[i] for i in np.argsort(without)[::-1]])


def is_near(one, other):
    """Do two candidates act at the same joint, or one at what both stand on?"""
    return one.joint == other.joint or "base" in (one.joint, other.joint)


def over_blocks(gain, record):
    """The sum of gains over its standard deviation, by their spread within each recording: recordings differ in
    regime, not in noise."""
    variance = 1e-9
    for r in np.unique(record):
        if (record == r).sum() > 1:
            variance += (record == r).sum() * gain[record == r].var(ddof=1)
    return gain.sum() / np.sqrt(variance)


def plain_base(dataset):
    """Base parameters of the plain model by weighted least squares on the scored rows."""
    return Gram(dataset, [None] * len(dataset.processed_recordings), []).fold_strengths([])[-1][:dataset.bases]


def machine_bases(dataset):
    """Base parameters that a machine can have, the plain model's first."""
    plain = plain_base(dataset)
    if has_inertia(dataset, plain):
        yield plain
    yield from Search(dataset, dataset.identified, sparse if dataset.at_motor else list).bases_beside()


def search(dataset, base, step=lambda text, part=0.0: None, seed=1, replicated=True):
    """(search, fit): the search at the parameters that suit the best effect, and the effects chosen. `replicated`: against
    replicates of these recordings without any effect."""
    step("candidates")
    first = Search(dataset, base, sparse if dataset.at_motor else list)
    step("single effects")
    singles = first.scan([], looking=True)
    # candidates are made of the plain model's torques, and coloured noise shows beside a model that knows the motion:
    # once more, at parameters fitted with the best effect
    best = first.plain
    if singles and first.significant(first.plain, singles[0], 0.0):
        best = refined(first, singles[0], 0)
    again = first.base_of(best.chosen)
    left = Residuals(first, best.chosen)
    dataset.find_sigma(lambda c: left.of[c.record, c.kind])
    if not np.all(np.isfinite(again)) or not best.chosen:
        again = base
    excess, wanted = torque_constant_error(best.chosen, best.strengths), list
    if dataset.at_motor:  # a body that closes little in a first look can be no more than a second effect, whose shape is refined
        gained = {fit.chosen[-1].key: first.plain.excess - fit.excess for fit in singles}
        much = {key for key in gained if gained[key] > PROMISING * max(gained.values())}
        whole = {c.key for c in first.gram.candidates if not dataset.effects[c.effect].integrated} | much
        wanted = functools.partial(sparse, whole=whole)
    del first, singles, best
    gc.collect()  # candidates hold their torque terms in circles
    step("candidates, once more")
    second = Search(dataset, again, wanted, excess)
    if replicated:
        second.calibrate(Replicator(sparse if dataset.at_motor else list, seed, step))
    step("combinations")
    singles = second.something_alone()
    fit = second.extended(singles) if singles else second.plain
    second.look_outside(singles)
    return second, fit
