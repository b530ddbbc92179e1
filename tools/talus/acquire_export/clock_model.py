"""The record's clocks: from the realtime stamps of frames to CLOCK_MONOTONIC, also where the clock was set meanwhile.

    model = ClockModel(clocks)                   # [Clock(mono_ns, real_ns, width_ns, is_set)] in the order of the events file
    mono_ns = model.convert(real_ns)             # stamps of one interface in the order of their lines
    model.steps                                  # [Step(...)]

Two clocks that run drift against each other by some hundred parts in a million, whatever NTP does. Where the offset between
realtime and monotonic changes by more from one reading to the next, the clock was set. Between two such steps the model is
straight from reading to reading. Where a step lies between two readings is told by the frames: their stamps jump there.
"""

from dataclasses import dataclass, field

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
    rows: list = field(default_factory=list)  # first frame behind it, of each interface that was converted


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
        begin, out = 0, np.empty(len(real_ns), np.int64)
        for piece, step in zip(self.pieces, [*self.steps, None], strict=True):
            end = self.first_behind(real_ns, begin, piece, step) if step else len(real_ns)
            out[begin:end] = piece.convert(real_ns[begin:end])
            if step:
                step.rows.append(end)
            begin = end
        return out

    @staticmethod
    def first_behind(real_ns, begin, piece, step):
        """The first frame that was stamped behind a step: between its two readings, where the stamps move most its way."""
        rest = real_ns[begin:]
        if not len(rest):
            return begin
        move = np.diff(rest, prepend=rest[0])
        arrival = arrivals(int(piece.convert(rest[:1])[0]), move, step.size_ns)
        if arrival[0] > step.after.mono_ns + SLACK_NS:
            return begin
        before = np.append(arrival[0], arrival[:-1])
        near = (arrival >= step.before.mono_ns - SLACK_NS) & (before <= step.after.mono_ns + SLACK_NS)
        soon = near & (arrival >= step.after.mono_ns - SOON_NS)
        near = soon if step.after.is_set and soon.any() else near
        near[0] = False
        if not near.any():  # no frame came in between: the next one is behind it
            return begin + int(np.searchsorted(arrival, step.before.mono_ns, "right"))
        return begin + choose(np.flatnonzero(near), move * (1 if step.size_ns > 0 else -1), step)


def arrivals(first_ns, move, size_ns):
    """About when frames came, by their stamps' moves: what may be the step itself is no time that passed."""
    passed = np.maximum(move, 0)
    return first_ns + np.cumsum(passed - size_ns * (passed >= size_ns) if size_ns > 0 else passed)


def choose(candidates, move, step):
    """The frame of the largest move. Stamps of one piece rise: a fall can only be the step, a rise only if it is as large.
    Where several frames fit, the instants between them are uncertain."""
    best = int(candidates[np.argmax(move[candidates])])
    fits = move[candidates] >= step.size_ns if step.size_ns > 0 else move[candidates] >= min(move[best], 0)
    if fits.sum() > 1:
        step.uncertain_ns = abs(step.size_ns)
    return best
