"""Counts to angles: the relative encoder of a motor is unrolled and zeroed by the absolute one at its joint."""

import numpy as np
from talus.refused import Refused


TURN = 2 * np.pi


def joint_angle(counts, bus):
    """An absolute encoder's angle [rad]: 0 at `zero_count`, within half a turn of it."""
    per_turn = bus["counts_per_turn"]
    offset = counts - bus["zero_count"]
    return bus["sign"] * TURN * (offset - per_turn * np.floor(offset / per_turn + 0.5)) / per_turn


class Zeroed:
    """A counter that wraps at `span`, zeroed from where the joint's encoder and the transmission say that the motor is. No
    sample needs its neighbours: a gap costs nothing.

    zeroed.take(counts, expected_rad)       # chunk by chunk
    zero, spread = zeroed.find_zero()       # both in counts
    for angle in zeroed.angles(): ...       # [rad], in the same chunks
    """

    def __init__(self, span, bus, store):
        self.span, self.bus, self.store = span, bus, store
        self.rows = store.spool([("count", "f8"), ("expected", "f8")])
        self.direction, self.middle = 0j, 0.0

    def take(self, counts, expected_rad):
        expected = self.bus["sign"] * expected_rad / TURN * self.bus["counts_per_turn"]
        self.direction += np.exp(2j * np.pi * (counts - expected) / self.span).sum()
        self.rows.append_columns(counts, expected)

    def errors(self):
        """Chunks of (expected, error): by how much the counter differs from it, beside what all differ by."""
        for rows in self.rows.chunks():
            error = rows["count"] - rows["expected"] - self.near
            error -= self.span * np.floor(error / self.span + 0.5)
            yield rows["expected"], error

    def find_zero(self):
        self.near = float(np.angle(self.direction)) * self.span / TURN
        means, total, squares = PlaceMeans(self.store), 0.0, 0.0
        for expected, error in self.errors():
            means.take(np.rint(expected + self.near + error).astype(np.int64), error)
            total, squares = total + float(error.sum()), squares + float((error**2).sum())
        self.middle, count = means.result(), len(self.rows)
        spread = max(squares / count - (total / count) ** 2, 0.0) ** 0.5
        return float((self.near + self.middle) % self.span), spread

    def angles(self):
        for expected, error in self.errors():
            yield self.bus["sign"] * TURN * (expected + error - self.middle) / self.bus["counts_per_turn"]


class PlaceMeans:
    """The mean in which each place counts once, however long the joint stood there: the absolute encoder's
    rounding, coarse after the transmission, is another at each place and averages out, but not at one. Places go to shares
    of which each fits into memory."""

    SHARES = 32

    def __init__(self, store):
        self.shares = [store.spool([("place", "i8"), ("total", "f8"), ("count", "f8")]) for _ in range(self.SHARES)]

    def take(self, place, error):
        places, total, count = per_place(place, error, np.ones(len(error)))
        for number, share in enumerate(self.shares):
            those = places % self.SHARES == number
            share.append_columns(places[those], total[those], count[those])

    def result(self):
        total, places = 0.0, 0
        for share in self.shares:
            own = error = count = np.empty(0)
            for rows in share.chunks():
                columns = zip((own, error, count), (rows[name] for name in ("place", "total", "count")), strict=True)
                own, error, count = per_place(*(np.append(*pair) for pair in columns))
            total, places = total + float((error / count).sum()), places + len(own)
        return total / places


def per_place(place, total, count):
    """(each place, its total, its count)."""
    places, which = np.unique(place, return_inverse=True)
    return places, np.bincount(which, total, len(places)), np.bincount(which, count, len(places))


class Unrolled:
    """Without an absolute encoder: from the first sample on, the shorter way from each to the next."""

    def __init__(self, span, bus):
        self.span, self.bus, self.last, self.turned = span, bus, None, 0

    def __call__(self, counts):
        if not len(counts):
            return np.empty(0)
        step = np.diff(counts, prepend=counts[0] if self.last is None else self.last)
        step = (step + self.span // 2) % self.span - self.span // 2
        turned = self.turned + np.cumsum(step)
        self.last, self.turned = counts[-1], int(turned[-1])
        return self.bus["sign"] * TURN * turned / self.bus["counts_per_turn"]


def check_spread(name, spread, span):
    """Two encoders of one joint that say the same differ by far less than the counter's span."""
    if spread > span / 8:
        raise Refused(2, f"{name}: motor and joint encoder contradict each other by {spread:.0f} counts (standard "
                         "deviation); counts_per_turn, sign or zero_count of bus: in the model file, or its "
                         "transmission, are not this bench's")  # fmt: skip
