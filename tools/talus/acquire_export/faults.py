"""Faults of a message's frames: all are counted, and so many listed as anybody reads."""

from array import array
from collections import Counter
from dataclasses import dataclass

KINDS = ("lost", "repeated", "swapped", "late", "short", "silent", "restarted", "jumped", "contradicting", "stale", "unusable")
MOST_LISTED = 50_000  # of all messages
ALWAYS_LISTED = 10  # of each kind of a message


@dataclass(frozen=True)
class Fault:
    kind: str
    index: int  # of the frame; of a loss, the frame that follows it; of a short frame, its line
    number: int  # of the frame, or of the first lost one
    count: int = 1


class Faults:
    def __init__(self, budget=None):
        self.budget = budget or Budget()
        self.kind, self.index, self.number, self.counts = bytearray(), array("q"), array("q"), array("q")
        self.frames, self.places = Counter(), Counter()  # by kind
        self.last = {}  # where the newest of a kind is listed

    def add(self, kind, index, number, count=1):
        self.frames[kind] += count
        self.places[kind] += 1
        self.last[kind] = None
        if self.places[kind] <= ALWAYS_LISTED or self.budget.take():
            self.last[kind] = len(self.kind)
            self.kind.append(KINDS.index(kind))
            self.index.append(index)
            self.number.append(number)
            self.counts.append(count)

    def grow(self, kind):
        """The newest one of a kind goes on by a frame."""
        self.frames[kind] += 1
        if self.last[kind] is not None:
            self.counts[self.last[kind]] += 1

    def __len__(self):
        return len(self.kind)

    def __iter__(self):
        for k in range(len(self.kind)):
            yield Fault(KINDS[self.kind[k]], self.index[k], self.number[k], self.counts[k])

    @property
    def not_listed(self):
        return sum(self.places.values()) - len(self.kind)


class Budget:
    def __init__(self, left=MOST_LISTED):
        self.left = left

    def take(self):
        self.left -= 1
        return self.left >= 0
