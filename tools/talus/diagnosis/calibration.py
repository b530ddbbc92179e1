"""What a search finds where nothing is: from null replicates the probability that a gain is nothing but noise and reconstruction.

Gains of the best single effect are lognormal over replicates of one recording. With m and s their logarithms' mean and
deviation over B replicates, and x that of the recording's own gain,

    w^2 = s^2 (1 + 1/B) + MISFIT^2,   z = (x - m) / w,
    P(nothing) = n(z)/w / (n(z)/w + N(z)/RANGE),

n and N the normal density and distribution: without an effect x is one more replicate, with one it lies anywhere in a
range above them, each size as likely as the next (docs/diagnosis.md).
"""

import math
import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from . import replicates

PROCESSES = 2
FEWEST, MOST = 3, 9  # replicates: more where the first ones leave it open
SURE_BELOW, SURE_ABOVE = 0.5, 5.0  # widths from the nulls' middle, beyond which more replicates would change nothing
MISFIT = 0.6  # of the logarithm: how far the gains of simulated nulls are off those of recordings with nothing hidden
RANGE = math.log(1000.0)  # of an effect's gain over the nulls', before the data
FLOOR = 8.0  # chi-square, added to gains: below it the logarithm tells noise apart from noise


class Calibration:
    """`own` gain of the best single effect, and its `gains` in each replicate; `excess`: {kind: mean chi-square that
    reconstruction leaves there}."""

    def __init__(self, own, gains, excess):
        self.own, self.gains, self.excess = own, list(gains), excess
        logs = np.log(np.maximum(self.gains, 0.0) + FLOOR)
        self.middle = float(np.mean(logs))
        spread = float(np.var(logs, ddof=1)) * (1 + 1 / len(logs)) if len(logs) > 1 else 0.0
        self.width = math.sqrt(spread + MISFIT**2)

    def widths(self, gain):
        """How far a gain lies above the nulls', in their widths."""
        return (math.log(max(gain, 0.0) + FLOOR) - self.middle) / self.width

    def nothing_of(self, gain):
        """The same of a step between the grid's shapes, which replicates do not take: as far as the grid goes."""
        return self.nothing(min(gain, self.own))

    def nothing(self, gain):
        """Probability that a gain is nothing but noise and reconstruction."""
        z = self.widths(gain)
        null = math.exp(-0.5 * z * z) / math.sqrt(2 * math.pi) / self.width
        other = 0.5 * math.erfc(-z / math.sqrt(2)) / RANGE
        return null / (null + other) if null + other > 0 else float(z < 0)


class Replicator:
    """Makes calibrations of one search: its candidates, seed, and how it tells its progress."""

    def __init__(self, choose, seed, step):
        self.choose, self.seed, self.step = choose, seed, step

    def beside(self, search, fit):
        """Calibration of one more effect beside those of a fit (of the first one beside none), or None where the recordings cannot
        be simulated with these."""
        base = search.gram.fold_strengths(search.columns(fit.chosen))[-1][:search.dataset.bases]
        source = replicates.Source.of(search.dataset, base, fit.chosen, fit.strengths)
        if source is None:
            return None
        own, found = gain_beside(search, fit.chosen), []
        for numbers in (range(FEWEST), range(FEWEST, MOST)):
            found += [one for one in self._each(source, fit.chosen, numbers) if one is not None]
            if len(found) < 2:
                return None
            excess = {kind: float(np.mean([e[kind] for _, e in found])) for kind in search.dataset.kinds}
            out = Calibration(own, [gain for gain, _ in found], excess)
            if not SURE_BELOW < out.widths(own) < SURE_ABOVE:
                break
        return out

    def _each(self, source, chosen, numbers):
        """(gain, excess by kind) of some replicates, on two processors where that can be."""
        global _work
        _work = source, self.choose, self.seed, chosen
        try:
            if multiprocessing.current_process().daemon:
                return [_one(number) for number in numbers]
            with ProcessPoolExecutor(PROCESSES, multiprocessing.get_context("fork")) as pool:
                out = []
                for number, one in zip(numbers, pool.map(_one, numbers)):
                    self.step(f"replicates without {'a further' if chosen else 'any'} effect, {number + 1}")
                    out.append(one)
                return out
        finally:
            _work = None


def gain_beside(search, chosen):
    """What the best single shape of the grid gains beside the chosen effects."""
    found = search.scan(chosen)
    return search.fit(chosen).excess - found[0].excess if found else 0.0


_work = None  # what the processes that are forked take with them


def _one(number):
    """One replicate, searched as the recording is; None where nothing of it can be used."""
    from .search import Search, plain_base  # which calls this

    source, choose, seed, chosen = _work
    dataset = source.replicate(seed, number)
    if dataset is None:
        return None
    search = Search(dataset, plain_base(dataset), choose)
    blocks = search.gram.held_out_blocks(search.columns(chosen))
    return gain_beside(search, chosen), {kind: float(values.sum()) - dataset.freedom(kind) for kind, values in blocks.items()}
