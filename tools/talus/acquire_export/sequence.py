"""What a payload's counter says about the frames of one message: which are lost, repeated, out of their order.

    sequence = follow(counter, bits, time_ns, period_s)
    sequence.number     # the counter without its wraps, for every frame
    sequence.kept       # indices of the frames to use, in the order of their numbers
    sequence.faults     # [Fault("lost", index, number, count), ...]

A counter of n bits tells apart everything but the loss of exactly a multiple of 2^n frames in a row; where the
period is known the stamps tell even that. What stood before the first frame and behind the last one no counter
can tell.
"""

from bisect import bisect_right
from dataclasses import dataclass, field

import numpy as np

SURE = 3  # frames that follow each other behind a jump back: the sender began anew
NEAR_WHOLE = 0.02  # of a turn of the counter
IMPLAUSIBLE = 1000  # a jump forward by more than this, in less than half of its time, is a new beginning too


@dataclass
class Fault:
    kind: str  # lost, repeated, contradicting, swapped, restarted
    index: int  # of the frame; of a loss, the frame that follows it
    number: int  # of the frame, or of the first lost one
    count: int = 1


@dataclass
class Sequence:
    number: np.ndarray
    kept: np.ndarray
    faults: list = field(default_factory=list)

    def count(self, *kinds):
        return sum(fault.count for fault in self.faults if fault.kind in kinds)


def steps_of(counter, bits, time_ns, period_s):
    """Differences of a wrapping counter: the small ones, or whole turns more where the stamps fit just that.
    (A clock that was set forward fits no whole number of turns, but by chance.)"""
    turn = 1 << bits
    step = np.diff(counter.astype(np.int64))
    step = (step + turn // 2) % turn - turn // 2
    if period_s:
        turns = (np.diff(time_ns) / (period_s * 1e9) - step) / turn
        whole = np.rint(turns)
        step += turn * np.where((whole > 0) & (np.abs(turns - whole) < NEAR_WHOLE), whole, 0).astype(np.int64)
    return step


class Missing:
    """Numbers that have not come yet: ranges [first, end) that rise, each with the frame that showed its gap."""

    def __init__(self):
        self.first, self.ranges = [], []

    def add(self, first, end, index):
        if first < end:
            place = bisect_right(self.first, first)
            self.first.insert(place, first)
            self.ranges.insert(place, (first, end, index))

    def take(self, number):
        """Was it missing? Then it is so no longer."""
        place = bisect_right(self.first, number) - 1
        if place < 0 or number >= self.ranges[place][1]:
            return False
        first, end, index = self.ranges.pop(place)
        self.first.pop(place)
        self.add(number + 1, end, index)
        self.add(first, number, index)
        return True


class Follower:
    """Walks through the steps, frame by frame only where they are not 1."""

    def __init__(self, step, time_ns, period_s, same, turn):
        self.step, self.time_ns, self.period_s, self.same, self.turn = step, time_ns, period_s, same, turn
        self.odd = np.flatnonzero(step != 1)
        self.number = np.zeros(len(step) + 1, np.int64)
        self.drop = []
        self.faults = []
        self.most = 0  # the highest number of the lives before

    def begin(self, index, number):
        self.low = self.high = self.number[index] = number
        self.missing, self.first, self.looked_up = Missing(), {}, index
        self.most = max(self.most, number)

    def close(self):
        """What is still missing is lost."""
        for first, end, index in self.missing.ranges:
            self.faults.append(Fault("lost", index, first, end - first))

    def begins_anew(self, index):
        """Does the sender begin anew at this frame, whose step is not 1?"""
        step = self.step[index - 1]
        if step > IMPLAUSIBLE and self.period_s:
            return self.time_ns[index] - self.time_ns[index - 1] < 0.5e9 * step * self.period_s
        behind = self.step[index:index + SURE]
        return bool(step < 0 and len(behind) == SURE and (behind == 1).all())

    def run(self, first):
        self.begin(0, first)
        index = 0
        while True:
            index = self.smooth(index)
            if index == len(self.step):
                break
            index += 1
            self.place(index)
        self.close()

    def smooth(self, index):
        """On over frames that follow each other, as long as they are the newest; the last one of them."""
        if self.number[index] < self.high:
            return index
        where = np.searchsorted(self.odd, index)
        last = int(self.odd[where]) if where < len(self.odd) else len(self.step)
        self.number[index:last + 1] = self.number[index] + np.arange(last + 1 - index)
        self.high = int(self.number[last])
        return last

    def place(self, index):
        """One frame by itself."""
        number = int(self.number[index - 1] + self.step[index - 1])
        if number > self.high:
            if number > self.high + 1 and self.begins_anew(index):
                self.anew(index, number)
                return
            self.missing.add(self.high + 1, number, index)
            self.high = number
        elif self.missing.take(number):
            self.faults.append(Fault("swapped", index, number))
        elif number < self.low:
            if self.begins_anew(index):
                self.anew(index, number)
                return
            self.missing.add(number + 1, self.low, index)
            self.low = number
            self.faults.append(Fault("swapped", index, number))
        else:
            equal = self.same(self.first_with(number, index), index)
            if not equal and self.begins_anew(index):
                self.anew(index, number)
                return
            self.came_before("repeated" if equal else "contradicting", index, number)
            self.drop.append(index)
        self.number[index] = number

    def first_with(self, number, index):
        """The first frame of this life that had the number."""
        for behind in range(self.looked_up, index):
            self.first.setdefault(int(self.number[behind]), behind)
        self.looked_up = index
        return self.first[number]

    def came_before(self, kind, index, number):
        """A frame whose number there was; those that repeat a whole stretch are one fault."""
        last = self.faults[-1] if self.faults else None
        if last and last.kind == kind and (last.index + last.count, last.number + last.count) == (index, number):
            last.count += 1
        else:
            self.faults.append(Fault(kind, index, number))

    def anew(self, index, number):
        """Another life of the sender: its numbers stand behind all earlier ones, by whole turns of the counter."""
        self.close()
        self.most = max(self.most, self.high)
        self.faults.append(Fault("restarted", index, number))
        behind = self.most + 1 - number
        self.begin(index, number + self.turn * max(-(-behind // self.turn), 0))


def follow(counter, bits, time_ns, period_s=0.0, same=lambda a, b: True):
    """The Sequence of a message's frames in the order of the record; `same(a, b)`: are two frames equal?"""
    follower = Follower(steps_of(counter, bits, time_ns, period_s), time_ns, period_s, same, 1 << bits)
    follower.run(int(counter[0]))
    keep = np.ones(len(counter), bool)
    keep[follower.drop] = False
    kept = np.flatnonzero(keep)
    kept = kept[np.argsort(follower.number[kept], kind="stable")]
    return Sequence(follower.number, kept, sorted(follower.faults, key=lambda fault: (fault.index, fault.number)))
