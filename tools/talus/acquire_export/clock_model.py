"""The record's clocks: from the realtime stamps of frames to CLOCK_MONOTONIC, also where the clock was set meanwhile.

    model = ClockModel(clocks)                   # [Clock(mono_ns, real_ns, width_ns, is_set)] in the order of the events file
    mono_ns = model.convert(real_ns)             # stamps of one interface in the order of their lines
    model.steps                                  # [Step(...)]

Two clocks that run drift against each other by some hundred parts in a million, whatever NTP does. Where the offset between
realtime and monotonic changes by more from one reading to the next, the clock was set. Between two such steps the model is
straight from reading to reading. Where a step lies between two readings is told by the frames: their stamps jump there.
"""

from dataclasses import dataclass

import numpy as np

MOST_DRIFT = 600e-6  # NTP slews by 500e-6, and quartzes differ
READ_NS = 20_000  # two readings within less than this of a straight line are on it
SLACK_NS = 5_000_000  # a frame's line may stand so far from its time among the readings
SOON_NS = 100_000_000  # the recorder reads the clocks at once when one is set


@dataclass(frozen=True)
class Clock:
    mono_ns: int
    real_ns: int
    width_ns: int = 0
    is_set: bool = False  # read because the kernel said that the clock was set

    @property
    def offset_ns(self):
        return self.real_ns - self.mono_ns


@dataclass
class Step:
    before: Clock
    after: Clock
    size_ns: int  # of realtime; negative: back
    uncertain_ns: int = 0  # instants near the step may be off by so much


class Piece:
    """Readings between two steps."""

    def __init__(self, clocks):
        self.zero = clocks[0]
        self.real = np.array([clock.real_ns - self.zero.real_ns for clock in clocks], float)
        self.drift = np.array([clock.offset_ns - self.zero.offset_ns for clock in clocks], float)

    def offset(self, real_ns):
        """Realtime less monotonic [ns] less the first reading's, at stamps of this piece; beyond its ends as at them."""
        x = (real_ns - self.zero.real_ns).astype(float)
        return np.interp(x, self.real, self.drift) + self.beyond(x)

    def beyond(self, x):
        """What is added before the first reading and behind the last one: the drift between the two next to it."""
        if len(self.real) < 2:
            return 0.0
        slope = np.clip(np.diff(self.drift) / np.maximum(np.diff(self.real), 1.0), -MOST_DRIFT, MOST_DRIFT)
        return slope[0] * np.minimum(x - self.real[0], 0.0) + slope[-1] * np.maximum(x - self.real[-1], 0.0)

    def convert(self, real_ns):
        return real_ns - self.zero.offset_ns - np.rint(self.offset(real_ns)).astype(np.int64)


def is_step(a, b):
    apart = abs(b.offset_ns - a.offset_ns)
    return apart > MOST_DRIFT * abs(b.mono_ns - a.mono_ns) + a.width_ns + b.width_ns + READ_NS


class ClockModel:
    def __init__(self, clocks):
        rising = [clock for k, clock in enumerate(clocks) if k == 0 or clock.mono_ns > clocks[k - 1].mono_ns]
        self.steps, pieces = [], [rising[:1]]
        for a, b in zip(rising, rising[1:], strict=False):
            if is_step(a, b):
                self.steps.append(Step(a, b, b.offset_ns - a.offset_ns))
                pieces.append([])
            pieces[-1].append(b)
        self.pieces = [Piece(piece) for piece in pieces if piece]

    def convert(self, real_ns):
        """Stamps on the monotonic clock; None without a reading."""
        if not self.pieces:
            return None
        edges = self.edges(lambda first: iter([real_ns[first:]]), len(real_ns))
        return self.convert_between(real_ns, np.searchsorted(edges, np.arange(len(real_ns)), "right"))

    def convert_between(self, real_ns, piece):
        """Stamps of which it is known behind how many steps they lie."""
        out = np.empty(len(real_ns), np.int64)
        for number in np.unique(piece):
            out[piece == number] = self.pieces[number].convert(real_ns[piece == number])
        return out

    def edges(self, chunks, count):
        """The first frame behind each step, of the `count` frames of an interface; chunks(first): their stamps from one on."""
        begin, found = 0, []
        for piece, step in zip(self.pieces, self.steps, strict=False):
            begin = first_behind(chunks(begin), begin, piece, step) if begin < count else count
            found.append(begin)
        return found


def first_behind(chunks, begin, piece, step):
    """The first frame that was stamped behind a step: between its two readings, where the stamps move most its way."""
    search, first, last_ns, arrived = Search(step), begin, None, None
    for real_ns in chunks:
        if not len(real_ns):
            continue
        move = np.diff(real_ns, prepend=real_ns[0] if last_ns is None else last_ns)
        alone = arrived is None
        arrived = int(piece.convert(real_ns[:1])[0]) if alone else arrived
        arrival = arrivals(arrived, move, step.size_ns)
        if alone and arrival[0] > step.after.mono_ns + SLACK_NS:
            return begin
        search.take(first, move, arrival, np.append(arrival[0] if alone else arrived, arrival[:-1]), alone)
        first, last_ns, arrived = first + len(real_ns), real_ns[-1], int(arrival[-1])
        if arrived > step.after.mono_ns + SLACK_NS:
            break
    return search.result(begin)


class Search:
    """Goes through the frames near a step."""

    def __init__(self, step):
        self.step, self.before = step, 0  # frames that came before the step's first reading
        self.near, self.soon, self.any_soon = Candidates(step), Candidates(step), False

    def take(self, first, move, arrival, before, alone):
        step = self.step
        near = (arrival >= step.before.mono_ns - SLACK_NS) & (before <= step.after.mono_ns + SLACK_NS)
        soon = near & (arrival >= step.after.mono_ns - SOON_NS)
        self.any_soon |= bool(soon.any())
        if alone:
            near[0] = soon[0] = False
        self.near.take(first, move, near)
        self.soon.take(first, move, soon)
        self.before += int(np.searchsorted(arrival, step.before.mono_ns, "right"))

    def result(self, begin):
        candidates = self.soon if self.step.after.is_set and self.any_soon else self.near
        if candidates.best is None:  # no frame came in between: the next one is behind it
            return begin + self.before
        return candidates.choose()


class Candidates:
    """The frame of the largest move. Stamps of one piece rise: a fall can only be the step, a rise only if it is as large.
    Where several frames fit, the instants between them are uncertain."""

    def __init__(self, step):
        self.step, self.best, self.most = step, None, None
        self.equal = self.fit = 0  # frames with the largest move; with one that is large enough in any case

    def take(self, first, move, which):
        where = np.flatnonzero(which)
        if not len(where):
            return
        move = move[where] * (1 if self.step.size_ns > 0 else -1)
        most = int(move.max())
        if self.most is None or most > self.most:
            self.best, self.most, self.equal = first + int(where[np.argmax(move)]), most, 0
        self.equal += int((move == self.most).sum())
        self.fit += int((move >= max(self.step.size_ns, 0)).sum())

    def choose(self):
        only_fall = self.step.size_ns < 0 and self.most < 0
        if (self.equal if only_fall else self.fit) > 1:
            self.step.uncertain_ns = abs(self.step.size_ns)
        return self.best


def arrivals(first_ns, move, size_ns):
    """About when frames came, by their stamps' moves: what may be the step itself is no time that passed."""
    passed = np.maximum(move, 0)
    return first_ns + np.cumsum(passed - size_ns * (passed >= size_ns) if size_ns > 0 else passed)
