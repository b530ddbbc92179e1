"""Timing in turns, ratios with their spread, and how they are shown."""

import statistics
import time
from dataclasses import dataclass, field


def alternate(repetitions, clock=time.thread_time, **sides):
    """Runs the sides in turn, `repetitions` times each after one warm-up, and returns {name: [seconds]}.

    The default clock is the processor time of this thread: a machine that others use too stretches the
    clock on the wall, and not evenly. All sides run in this thread, NumPy with one thread (see run).
    """
    seconds = {name: [] for name in sides}
    for repetition in range(repetitions + 1):
        for name, call in sides.items():
            begin = clock()
            call()
            if repetition:
                seconds[name].append(clock() - begin)
    return seconds


def spread(ours, peer):
    """(lowest, highest) ratio of neighbours in time; of the middle 80 % where there are ten or more."""
    ratios = sorted(p / o for o, p in zip(ours, peer, strict=True))
    cut = len(ratios) // 10
    return ratios[cut], ratios[-1 - cut]


@dataclass
class Comparison:
    """One line of the table: seconds of both sides (already scaled to the whole work) and the bar, if any."""

    name: str
    ours_is: str
    peer_is: str
    ours_s: list
    peer_s: list
    bar: float | None = None
    note: str = ""

    @property
    def ratio(self):
        """How many times faster talus is: ratio of the medians."""
        return statistics.median(self.peer_s) / statistics.median(self.ours_s)

    @property
    def met(self):
        """Is the bar met? True without one."""
        return self.bar is None or self.ratio >= self.bar

    def lines(self):
        """The comparison in words."""
        low, high = spread(self.ours_s, self.peer_s)
        bar = "" if self.bar is None else f", bar {self.bar:,g}: {'met' if self.met else 'MISSED'}"
        yield f"{self.name}: {self.ratio:,.{digits(self.ratio)}f} times faster ({figure(low)} to {figure(high)}{bar})"
        yield f"  talus: {self.ours_is}: {duration(statistics.median(self.ours_s))}"
        yield f"  peer:  {self.peer_is}: {duration(statistics.median(self.peer_s))}"
        if self.note:
            yield f"  {self.note}"

    def as_json(self):
        """The comparison for results.json."""
        low, high = spread(self.ours_s, self.peer_s)
        return {
            "name": self.name, "talus": self.ours_is, "peer": self.peer_is, "ratio": self.ratio,
            "ratio_low": low, "ratio_high": high, "bar": self.bar, "met": self.met, "note": self.note,
            "talus_s": self.ours_s, "peer_s": self.peer_s,
        }  # fmt: skip


@dataclass
class Outcome:
    """What one bench found: comparisons, further lines for people, further figures for results.json, and
    the names of bars that are no ratio and were missed."""

    comparisons: list = field(default_factory=list)
    lines: list = field(default_factory=list)
    figures: dict = field(default_factory=dict)
    missed: list = field(default_factory=list)


def digits(ratio):
    """Decimals that a ratio deserves: three figures in all."""
    return 2 if ratio < 10 else 1 if ratio < 100 else 0


def figure(ratio):
    """A ratio with three figures."""
    return f"{ratio:,.{digits(ratio)}f}"


def duration(seconds):
    """A time with a fitting unit."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"
