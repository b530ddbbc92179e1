"""An adapter's own clock against the monotonic one, from pairs of its stamps with realtime.

    convert = to_monotonic(model, pairs)         # [Pair(hw_ns, real_ns, place)] in the order of the events file, or None

Where realtime was set meanwhile, a pair may lie on either side of the step. The recorder looks for a new pair about each
second: its frame came between the look before and this one, and both looks have their place among the readings of the
clocks. What that leaves open the adapter's clock tells, which knows no step: of all ways to place the pairs the one counts on
which both clocks go most evenly. What remains possible besides makes the instants around that pair uncertain.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .clock_model import MOST_DRIFT, READ_NS


@dataclass(frozen=True)
class Pair:
    hw_ns: int
    real_ns: int
    place: int  # readings of the clocks that stand before it in the events file


def to_monotonic(model, pairs):
    """A function from stamps of the adapter to the monotonic clock; None when nothing relates the two."""
    pairs = pairs if model.pieces else []
    return straight(placed(model, pairs) if model.steps else unplaced(model, pairs))


def unplaced(model, pairs):
    mono = model.convert(np.array([pair.real_ns for pair in pairs], np.int64)) if pairs else []
    return [(pair.hw_ns, int(t)) for pair, t in zip(pairs, mono, strict=True)]


def straight(pairs):
    """A function from the first clock of the pairs to the second: straight between them, beyond them with their drift from
    the first one to the last. None when there are no pairs or the first clock was set back."""
    pairs = sorted(set(pairs), key=lambda pair: pair[1])
    first, second = (np.array(column, np.int64) for column in zip(*pairs, strict=True)) if pairs else ([], [])
    if len(first) == 0 or np.any(np.diff(first) <= 0):
        return None
    x, offset = (first - first[0]).astype(float), second - first
    drift = float(np.clip((offset[-1] - offset[0]) / max(x[-1], 1.0), -MOST_DRIFT, MOST_DRIFT))

    def convert(t_ns):
        at = (t_ns - first[0]).astype(float)
        beyond = drift * (np.minimum(at, 0.0) + np.maximum(at - x[-1], 0.0))
        return t_ns + np.rint(np.interp(at, x, offset - offset[0]) + beyond).astype(np.int64) + offset[0]

    return convert


# ---- where the clock was set ----------------------------------------------------------------


def placed(model, pairs):
    """(adapter, monotonic) of each pair, as they go together most evenly."""
    news = list(new_pairs(pairs))
    ways = ways_of(model, news)
    likeliest = [[a + b for a, b in zip(*costs, strict=True)] for costs in zip(costs_upto(ways), costs_from(ways), strict=True)]
    chosen = [way[cost.index(min(cost))] for way, cost in zip(ways, likeliest, strict=True)]
    out = [(pair.hw_ns, pair.hw_ns + apart) for (_, pair), (_, apart) in zip(news, chosen, strict=True)]
    for k, (way, cost) in enumerate(zip(ways, likeliest, strict=True)):
        if len(way) > 1:
            around = out[max(k - 1, 0):k + 2]
            drift = MOST_DRIFT * abs(around[-1][0] - around[0][0]) + READ_NS
            from_ns = around[0][1] if k else min(model.first_ns, out[0][1])  # beyond the pairs the first and the last one count
            to_ns = around[-1][1] if k + 1 < len(out) else max(model.last_ns, out[-1][1])
            tell_doubt(model, way, cost, drift, (from_ns, to_ns))
    return out


def new_pairs(pairs):
    """(place of the look before, pair) of each pair that was not there at that look."""
    before = None
    for pair in pairs:
        if before is None or (pair.hw_ns, pair.real_ns) != (before.hw_ns, before.real_ns):
            yield (before.place if before else 0), pair
        before = pair


def ways_of(model, news):
    """[(piece, monotonic less adapter's clock)] for each pair: in which it may lie."""
    spans = [model.pieces_between(place, pair.place) for place, pair in news]
    of_pair = np.repeat(np.arange(len(news)), [len(span) for span in spans])
    piece = np.concatenate([np.array(span, np.int64) for span in spans]) if spans else np.empty(0, np.int64)
    mono = model.convert_between(np.array([news[k][1].real_ns for k in of_pair.tolist()], np.int64), piece)
    fits = model.is_in(mono, piece)
    found = [[] for _ in news]
    for k, number, t, fit in zip(of_pair.tolist(), piece.tolist(), mono.tolist(), fits.tolist(), strict=True):
        if fit or number == spans[k][-1] and not found[k]:
            found[k].append((number, t - news[k][1].hw_ns))
    return found


def costs_upto(ways):
    """The least unevenness of the pairs up to each way of each pair."""
    out, before = [], [(0, 0)]
    for way in ways:
        costs = [[cost + abs(apart - other) for (earlier, other), cost in zip(before, out[-1], strict=True) if earlier <= piece]
                 for piece, apart in way] if out else [[0]] * len(way)  # fmt: skip
        out.append([min(cost, default=1 << 63) for cost in costs])
        before = way
    return out


def costs_from(ways):
    """The same of the pairs behind it."""
    return costs_upto([[(-piece, apart) for piece, apart in way] for way in reversed(ways)])[::-1]


def tell_doubt(model, way, cost, drift, span_ns):
    """What is less even than the best by no more than drift makes may be as well."""
    best = cost.index(min(cost))
    for (piece, apart), more in zip(way, cost, strict=True):
        if piece != way[best][0] and more - cost[best] <= drift:
            for step in model.steps[min(piece, way[best][0]):max(piece, way[best][0])]:
                step.doubt(abs(apart - way[best][1]), *span_ns)
