"""The record's clocks: from the realtime stamps of frames to CLOCK_MONOTONIC, also where the clock was set meanwhile.

    model = ClockModel(clocks)                   # [Clock(mono_ns, real_ns, width_ns, is_set)] in the order of the events file
    mono_ns = model.convert(real_ns)             # stamps of one interface in the order of their lines
    model.steps                                  # [Step(...)]
    model.uncertain_ns                           # by so much instants may be off where even the quickest reading took long

Two clocks that run drift against each other by some hundred parts in a million, whatever NTP does. Where the offset between
realtime and monotonic changes by more from one reading to the next, the clock was set. Between two such steps the model is
straight from reading to reading. A reading is trusted as far as it says: one that took long among quick ones lies on the line
between these, or as near to it as its width allows; and beyond the readings of a piece no more drift goes on than their widths leave
no doubt of. Where a step lies between two readings is told by the frames (step_search.py); what
remains possible besides stands in the step: which instants are uncertain, and by how much.
"""

from dataclasses import dataclass

import numpy as np

from talus._library import files

from .step_search import MOST_AT_ONCE, first_behind

RULE = files()  # apps/clock: what a step is, for talus-acquire info as well
MOST_DRIFT = RULE.clock_most_drift()
READ_NS = int(RULE.clock_read_ns())  # two readings within less than this of a straight line are on it


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
    uncertain_ns: int = 0  # instants of `uncertain_from_ns` to `uncertain_to_ns` may be off by so much
    uncertain_from_ns: int = 0
    uncertain_to_ns: int = 0

    @property
    def width_ns(self):
        """How exactly the readings on either side relate a stamp between them to the monotonic clock."""
        return width_ns(self.before, self.after)

    def doubt(self, by_ns, from_ns, to_ns):
        """Instants of one interface are uncertain; those of others may be, too."""
        known = self.uncertain_ns > 0
        self.uncertain_from_ns = min(from_ns, self.uncertain_from_ns) if known else from_ns
        self.uncertain_to_ns = max(to_ns, self.uncertain_to_ns) if known else to_ns
        self.uncertain_ns = max(self.uncertain_ns, by_ns)


class Piece:
    """Readings between two steps."""

    def __init__(self, clocks):
        self.zero = clocks[0]
        self.real = np.array([clock.real_ns - self.zero.real_ns for clock in clocks], float)
        self.drift = np.array([clock.offset_ns - self.zero.offset_ns for clock in clocks], float)
        self.width = np.array([clock.width_ns for clock in clocks], float)
        self.draw_in()

    def draw_in(self):
        """Slow readings onto the line between the quick ones, as far as their widths allow. Where none is quick, the quickest is."""
        real, read, width = self.real, self.drift, self.width
        quick = width <= max(width.min(), READ_NS)
        self.real, self.drift, self.width = real[quick], read[quick], width[quick]
        line = np.interp(real, self.real, self.drift) + self.beyond(real)
        self.real, self.drift, self.width = real, np.clip(line, read - width / 2, read + width / 2), width

    def offset(self, real_ns):
        """Realtime less monotonic [ns] less the first reading's, at stamps of this piece."""
        x = (real_ns - self.zero.real_ns).astype(float)
        return np.interp(x, self.real, self.drift) + self.beyond(x)

    def beyond(self, x):
        """What is added before the first reading and behind the last one: the drift between the two next to it. Each may be off by
        half its width; soon after each other, two readings show a drift that is none."""
        if len(self.real) < 2:
            return 0.0
        rise, off = np.diff(self.drift), (self.width[1:] + self.width[:-1]) / 2
        sure = np.sign(rise) * np.maximum(np.abs(rise) - off, 0.0)
        slope = np.clip(sure / np.maximum(np.diff(self.real), 1.0), -MOST_DRIFT, MOST_DRIFT)
        return slope[0] * np.minimum(x - self.real[0], 0.0) + slope[-1] * np.maximum(x - self.real[-1], 0.0)

    def convert(self, real_ns):
        return real_ns - self.zero.offset_ns - np.rint(self.offset(real_ns)).astype(np.int64)


def width_ns(a, b):
    """By how much the offset may change from one reading to another while nobody sets the clock."""
    return RULE.clock_drift_most_ns(b.mono_ns - a.mono_ns, a.width_ns + b.width_ns)


def is_step(a, b):
    return abs(b.offset_ns - a.offset_ns) > width_ns(a, b)


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
        self.uncertain_ns = max((piece.width.min() / 2 for piece in self.pieces), default=0.0)
        self.first_ns, self.last_ns = (rising[k].mono_ns if rising else 0 for k in (0, -1))
        behind = np.array([step.after.mono_ns for step in self.steps], np.int64)
        latest = np.maximum.accumulate(np.array([clock.mono_ns for clock in clocks], np.int64)) if clocks else behind
        self.piece_of = np.searchsorted(behind, latest, "right")  # of each reading

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

    def pieces_between(self, place, end):
        """The pieces in which a frame may lie that came between two places in the events file, given as the number of readings
        that stand before them. A frame takes some time until it is noticed: it may have come a reading earlier."""
        first, last = (int(self.piece_of[min(max(k, 0), len(self.piece_of) - 1)]) for k in (place - 2, end))
        return range(first, last + 1)

    def is_in(self, mono_ns, piece):
        """May instants lie in these pieces? A piece ends somewhere before the next one's first reading."""
        wide = np.array([step.width_ns for step in self.steps])
        begins = np.append(-np.inf, np.array([step.before.mono_ns for step in self.steps]) - wide)
        ends = np.append(np.array([step.after.mono_ns for step in self.steps]) + wide, np.inf)
        return (mono_ns >= begins[piece]) & (mono_ns <= ends[piece])

    def edges(self, chunks, count):
        """The first frame behind each step, of the `count` frames of an interface; chunks(first): their stamps from one on."""
        begin, found = 0, []
        for k in range(len(self.steps)):
            begin = first_behind(chunks, begin, count, self.steps[k:k + MOST_AT_ONCE]) if begin < count else count
            found.append(begin)
        return found
