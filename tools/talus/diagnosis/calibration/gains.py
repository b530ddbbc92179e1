"""What a search finds where nothing is: from null replicates the probability that a gain is nothing but noise and reconstruction.

Gains of one effect at one joint, each of the best shape, are lognormal over replicates of one recording. With m and s their
logarithms' mean and deviation over B replicates, x that of the recording's own gain, K the number of effects and joints tried,

    w^2 = s^2 (1 + 1/B) + MISFIT^2,   z = (x - m) / w,
    P(nothing) = n(z)/w / (n(z)/w + N(z - DEVIATIONS) / (K RANGE)),

n and N the normal density and distribution: without the effect x is one more replicate, with it x lies anywhere in a range above
what the recording can show, each size as likely as the next, and before the data each of the K is as likely as any other
(docs/diagnosis.md). An effect too small to be seen counts as nothing.
"""

import functools
import math
import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from .. import processors
from ..motion import has_inertia
from .thresholds import DEVIATIONS, HALF, MISFIT, RANGE, TIMES_AS_MUCH
from . import replicates

FEWEST, MOST = 3, 9  # replicates: more where the first ones leave it open
SURE_BELOW, SURE_ABOVE = 0.5, 5.0  # widths from the nulls' middle, beyond which more replicates would change nothing


class Calibration:
    """Gains of the best shape of every (effect, joint): `own` {key: gain} in the recordings, `gains` [{key: gain}] in each replicate;
    `excess`: {kind: mean chi-square over its freedom that noise and reconstruction leave there}. `chance` is what the best column gains
    in what noise and reconstruction leave: it is added to gains, below it the logarithm tells noise apart from noise; TIMES_AS_MUCH of it is
    the gain that a search takes for an effect at all. `again(gain)` is what the best column gains by chance in what that gain leaves of the
    recordings, where that is more. `outside` are keys of causes outside the catalogue: whether there is an effect does not depend on them.
    `there` are those of the effects beside which all of them gain."""

    def __init__(self, own, gains, excess, chance, outside=(), again=lambda gain: 0.0, there=frozenset()):
        self.there = frozenset(there)
        self.own, self.gains, self.excess = own, gains, excess
        self.chance, self.again = chance, again
        self.keys = sorted(set(own).union(*gains) - set(outside))

    def by_nothing(self, key):
        """What an (effect, joint) gains in the replicates, on the average; 0 where noise alone would gain as much."""
        return max(float(np.mean([gains.get(key, 0.0) for gains in self.gains])), 0.0)

    def most_widths(self):
        """How far the gain of the (effect, joint) that stands out most lies above the nulls', in their widths."""
        return max((self._beside(key, gain)[0] for key, gain in self._known(self.own).items()), default=0.0)

    def _known(self, gains):
        """Of the catalogue's effects alone."""
        return {key: gains[key] for key in self.keys if key in gains}

    def nothing(self, key, gain):
        """Probability that an (effect, joint)'s gain is nothing but noise and reconstruction; it is one of many."""
        return self._probability(*self._beside(key, gain), max(len(self.keys), 1))

    def nothing_of(self, before, after):
        """The same of a step from one fit to another, of the likeliest effect that it adds. Replicates are searched on the grid of
        shapes: what lies between its points is not counted. Beside other effects than these an effect's own gain is no bound: what
        the first one does may hide the second."""
        there = {c.key for c in before.chosen}
        gain = before.excess - after.excess
        most = self.own if there == self.there else {}
        new = [c.key for c in after.chosen if c.key not in there]
        return min((self.nothing(key, min(gain, most.get(key, gain))) for key in new), default=0.0)

    def nothing_at_all(self):
        """Probability that no gain is anything: by the largest of all beside the largest of each replicate, and where it stands above
        that, by each effect's own beside its own there: then the readings did not do it. What is less than a search would name is
        hardly a gap: a drive that sees its encoder's steps, say, gives several effects a little that replicates do not have, but
        none of them much."""
        own = () if self.outdone() else (self._probability(*self._beside(key, gain, TIMES_AS_MUCH), max(len(self.keys), 1))
                                         for key, gain in self._known(self.own).items())  # fmt: skip
        return min([self._probability(*self._largest(), 1), *own])

    def nothing_left(self, larger):
        """The same of what the plain model leaves, whose logarithm is so much `larger` than that of what replicates leave."""
        return self._probability(larger / MISFIT, MISFIT, 1)

    def _beside(self, key, gain, times=1.0):
        """(widths above the replicates', width) of an (effect, joint)'s gain, none counted below so many times what chance gains."""
        return self._widths_of(gain, [gains.get(key, 0.0) for gains in self.gains], times)

    def outdone(self, gain=None):
        """Do the replicates' largest gains come near that of the recordings, or one gain of them? What the readings alone gain something
        so much may gain another effect as much in the recordings."""
        return self._largest(gain)[0] < HALF

    def by_readings(self, gain):
        """Probability that a gain is no more than what the readings alone gain something, whatever effect that is."""
        return self._probability(*self._largest(gain), 1)

    def _largest(self, gain=None):
        own, *nulls = (max(self._known(gains).values(), default=0.0) for gains in (self.own, *self.gains))
        return self._widths_of(own if gain is None else gain, nulls, TIMES_AS_MUCH)

    def _widths_of(self, gain, nulls, times):
        chance = times * max(self.chance, self.again(gain))
        own, *logs = (math.log(max(one, 0.0) + chance) for one in (gain, *nulls))
        middle, width = _lognormal(logs)
        return (own - middle) / width, width

    @staticmethod
    def _probability(z, width, tried):
        """Of nothing, of a gain that lies z widths above the nulls' and is one of many that were tried."""
        null = math.exp(-0.5 * z * z) / math.sqrt(2 * math.pi) / width
        other = 0.5 * math.erfc((DEVIATIONS - z) / math.sqrt(2)) / RANGE / tried
        return null / (null + other) if null + other > 0 else float(z < 0)


def _lognormal(logs):
    """(mean, width) of logarithms of gains, for one more of them."""
    spread = float(np.var(logs, ddof=1)) * (1 + 1 / len(logs)) if len(logs) > 1 else 0.0
    return float(np.mean(logs)), math.sqrt(spread + MISFIT**2)


class Replicator:
    """Makes calibrations of one search: its candidates, seed, and how it tells its progress."""

    def __init__(self, choose, seed, step):
        self.choose, self.seed, self.step, self._made = choose, seed, step, {}

    def beside(self, search, fit):
        """Calibration of one more effect beside those of a fit (of the first one beside none), or None where the recordings cannot
        be simulated with these."""
        key = tuple((candidate.key, candidate.shape) for candidate in fit.chosen)
        if key not in self._made:
            self._made[key] = self._beside(search, fit)
        return self._made[key]

    def _beside(self, search, fit):
        source = self._source(search, fit)
        if source is None:
            return None
        own, found, self.begin = gains_beside(search, fit.chosen), [], search.gram.release
        steps = source.excess_of_steps()
        for numbers in (range(FEWEST), range(FEWEST, MOST)):
            found += [one for one in self._each(source, fit.chosen, numbers) if one is not None]
            if len(found) < 2:
                return None
            excess = {kind: max(float(np.mean([e[kind] for _, e in found])), steps.get(kind, -np.inf)) for kind in search.dataset.kinds}
            outside = {key for gains in (own, *(gains for gains, _ in found)) for key in gains if search.is_outside(key)}
            out = Calibration(own, [gains for gains, _ in found], excess, by_chance(search, sum(excess.values())), outside,
                              functools.partial(by_chance_again, search, sum(excess.values()), fit.excess),
                              {c.key for c in fit.chosen})  # fmt: skip
            if not SURE_BELOW < out.most_widths() < SURE_ABOVE:
                break
        return out

    @staticmethod
    def _bases(search, fit):
        """Base parameters that may be a fit's machine's: its own, those of the first look's best effect, and, of the plain model, those beside
        another one."""
        yield search.base_of(fit.chosen)
        yield search.all_terms[0].base
        if not fit.chosen:
            yield from search.bases_beside()

    def _source(self, search, fit):
        """What replicates of a fit are made of: of the first parameters that a machine can have, and that let it move as it was recorded."""
        for base in self._bases(search, fit):
            if has_inertia(search.dataset, base):
                source = replicates.Source.of(search.dataset, search.dataset.with_whole_inertia(base), fit.chosen, fit.strengths)
                if source:
                    return source
        return None

    def _each(self, source, chosen, numbers):
        """(gain, excess by kind) of some replicates, on two processors where that can be."""
        global _work
        _work = source, self.choose, self.seed, chosen
        try:
            if multiprocessing.current_process().daemon:
                return [_one(number) for number in numbers]
            with ProcessPoolExecutor(processors.COUNT, multiprocessing.get_context("fork"), self.begin) as pool:
                out = []
                for number, one in zip(numbers, pool.map(_one, numbers)):
                    self.step(f"replicates without {'a further' if chosen else 'any'} effect, {number + 1}", (number + 1) / MOST)
                    out.append(one)
                return out
        finally:
            _work = None


def by_chance(search, excess, repeats=1.0):
    """What the best of all columns gains where so much excess is left: what it gains of white noise, times what is left over that noise.
    Excess that comes back in every period of a motion is one chance, not as many as it `repeats`, and gains so many times as much."""
    return search.chance * (1.0 + repeats * max(excess, 0.0) / search.freedom)


def by_chance_again(search, excess, before, gain):
    """The same in what a gain leaves of the excess that the recordings had `before`, but no more than replicates leave (`excess`), all of
    it coming back with the motion."""
    return by_chance(search, min(excess, before - gain), search.dataset.repeats())


def gains_beside(search, chosen, limits=True):
    """{(effect, joint): what its best shape gains beside the chosen effects, of the grid's or, while much is left, downhill of these}.
    Without `limits` whatever its strength: what noise gains an effect does not end where the effect's range does."""
    before, there, gains = search.fit(chosen).excess, {c.key for c in chosen}, {}
    found = search.scan(chosen, limits=limits)
    with search.with_outside(effects_too=False):
        outside = search.scan(chosen, limits=limits)
    for fit in [*found, *(search.led_to(chosen, found[0].excess) if found else []), *outside]:
        key = fit.chosen[-1].key
        if key not in there:
            gains[key] = max(gains.get(key, -np.inf), before - fit.excess)
    return gains


_work = None  # what the processes that are forked take with them


def _one(number):
    """One replicate, searched as the recording is; None where nothing of it can be used."""
    from ..search import Search, plain_base  # which calls this

    source, choose, seed, chosen = _work
    dataset = source.replicate(seed, number)
    if dataset is None:
        return None
    search = Search(dataset, plain_base(dataset), choose)
    blocks = search.gram.held_out_blocks(search.columns(chosen))
    return gains_beside(search, chosen, limits=False), {kind: float(values.sum()) - dataset.freedom(kind) for kind, values in blocks.items()}
