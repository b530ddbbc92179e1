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

FEWEST, MOST = 3, 9  # replicates: more where the first ones leave it open
SURE_BELOW, SURE_ABOVE = 0.5, 5.0  # widths from the nulls' middle, beyond which more replicates would change nothing
MISFIT = 0.6  # of the logarithm: how far the gains of simulated nulls are off those of recordings with nothing hidden
RANGE = math.log(1000.0)  # of an effect's gain over the nulls', before the data
FLOOR = 8.0  # chi-square, added to gains: below it the logarithm tells noise apart from noise


class Calibration:
    """`gains` of the best single effect in each replicate; `excess`: {kind: mean chi-square that reconstruction leaves there}."""

    def __init__(self, gains, excess):
        self.gains, self.excess = list(gains), excess
        logs = np.log(np.maximum(self.gains, 0.0) + FLOOR)
        self.middle = float(np.mean(logs))
        spread = float(np.var(logs, ddof=1)) * (1 + 1 / len(logs)) if len(logs) > 1 else 0.0
        self.width = math.sqrt(spread + MISFIT**2)

    def widths(self, gain):
        """How far a gain lies above the nulls', in their widths."""
        return (math.log(max(gain, 0.0) + FLOOR) - self.middle) / self.width

    def nothing(self, gain):
        """Probability that a gain is nothing but noise and reconstruction."""
        z = self.widths(gain)
        null = math.exp(-0.5 * z * z) / math.sqrt(2 * math.pi) / self.width
        other = 0.5 * math.erfc(-z / math.sqrt(2)) / RANGE
        return null / (null + other) if null + other > 0 else float(z < 0)


def gain_of(search):
    """What the best single shape of the grid gains."""
    found = search.scan([])
    return search.plain.excess - found[0].excess if found else 0.0


def calibrated(search, base, choose, seed, step):
    """Calibration of a search, or None where its recordings cannot be simulated."""
    source = replicates.Source.of(search, base)
    if source is None:
        return None
    own, found = gain_of(search), []
    for numbers in (range(FEWEST), range(FEWEST, MOST)):
        found += _each(source, choose, seed, numbers, step)
        found = [one for one in found if one is not None]
        if len(found) < 2:
            return None
        excess = {kind: float(np.mean([e[kind] for _, e in found])) for kind in search.dataset.kinds}
        out = Calibration([gain for gain, _ in found], excess)
        if not SURE_BELOW < out.widths(own) < SURE_ABOVE:
            break
    return out


def _each(source, choose, seed, numbers, step):
    """(gain, excess by kind) of some replicates, on two processors where that can be."""
    global _work
    _work = source, choose, seed
    try:
        if multiprocessing.current_process().daemon:
            return [_one(number) for number in numbers]
        with ProcessPoolExecutor(2, multiprocessing.get_context("fork")) as pool:
            out = []
            for count, one in enumerate(pool.map(_one, numbers)):
                step(f"replicates without any effect, {numbers[count] + 1}")
                out.append(one)
            return out
    finally:
        _work = None


_work = None


def _one(number):
    """One replicate, searched as the recording is; None where the search fails."""
    from .search import Search, plain_base  # which calls this

    source, choose, seed = _work
    dataset = source.replicate(seed, number)
    if dataset is None:
        return None
    search = Search(dataset, plain_base(dataset), choose)
    blocks = search.gram.held_out_blocks([])
    return gain_of(search), {kind: float(values.sum()) - dataset.freedom(kind) for kind, values in blocks.items()}
