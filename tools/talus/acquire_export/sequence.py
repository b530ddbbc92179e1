"""What a payload's counter says about the frames of one message: which are lost, repeated, out of their order.

    follower = Follower(Counting(bits, period_s), same, outputs)
    follower.feed(...)                 # chunk by chunk
    follower.close()

A counter of n bits tells apart everything but the loss of exactly a multiple of 2^n frames in a row; where the
period is known the stamps tell even that. What stood before the first frame and behind the last one no counter
can tell. The newest 100,000 numbers or so are held (window.py): a missing frame that comes later than that is left out as
stale.
"""

from dataclasses import dataclass

import numpy as np

from .window import Window

SURE = 3  # frames that follow each other behind a jump back: the sender began anew
NEAR_WHOLE = 0.02  # of a turn of the counter
IMPLAUSIBLE = 1000  # a jump forward by more than this, in less than half of its time, is a new beginning too
OVERTAKEN = 256  # frames before one that came too late among which those are looked for that overtook it
NO_DELAY_S = 10.0  # a frame whose stamp is further from its number's place than this was not late: a clock was set


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


@dataclass
class Outputs:
    """Where results go. Frames are counted from 0 in the order of the record."""

    keep: object  # keep(numbers, indices): frames to use, in the order of their numbers
    trust: object  # trust(flags): of each frame in the order of the record, did it come in its turn?
    find: object  # find(number): the frame that had a number which was kept long ago, or None
    edge: object  # edge(index): behind a life: the frames from here on have no known place against those before
    faults: object


class Follower:
    """Walks through the steps, frame by frame only where they are not 1."""

    def __init__(self, bits, period_s, same, outputs):
        self.bits, self.turn, self.period_s, self.same, self.outputs = bits, 1 << bits, period_s, same, outputs
        self.faults = outputs.faults
        self.window = Window(outputs.keep, self.lose)
        self.number, self.trusted = np.empty(0, np.int64), np.empty(0, bool)  # of the newest frames
        self.first = 0  # the frame that stands first in them
        self.most = 0  # the highest number of the lives before
        self.floor = None  # the highest number of earlier lives
        self.begun = False
        self.end = 0
        self.again = None  # (kind, frame, number) that would continue a repeated stretch

    def feed(self, first, end, counter, time_ns, low):
        """Places the frames [first, end). The columns begin with frame `low`, one before `first` where there is one, and end
        with some frames behind `end`, by which a new beginning is known."""
        self.low_index, self.time_ns = low, time_ns
        self.step = steps_of(counter, self.bits, time_ns, self.period_s)
        self.odd = np.flatnonzero(self.step != 1) + low + 1
        self.number = np.append(self.number, np.zeros(end - first, np.int64))
        self.trusted = np.append(self.trusted, np.ones(end - first, bool))
        self.anews = []
        if not self.begun:
            self.begin(0, int(counter[0]))
            self.begun = True
        self.walk(max(first, 1), end)
        self.mark_lives(first, end)
        self.forget(max(len(self.number) - OVERTAKEN, 0))
        self.end = end

    def close(self):
        self.forget(len(self.number))
        self.window.close()
        self.outputs.edge(self.end)

    def forget(self, count):
        self.outputs.trust(self.trusted[:count])
        self.number, self.trusted, self.first = self.number[count:], self.trusted[count:], self.first + count

    def mark_lives(self, first, end):
        """Edges between lives: new beginnings, and stamps that jump."""
        edges = set(self.anews)
        begin = max(first, 1)
        if self.period_s and end > begin:
            time_ns = self.time_ns[begin - 1 - self.low_index:end - self.low_index]
            number = self.number[begin - 1 - self.first:end - self.first]
            apart = np.diff(time_ns).astype(float) - np.diff(number) * (1e9 * self.period_s)
            for index in (np.flatnonzero(np.abs(apart) > NO_DELAY_S * 1e9) + begin).tolist():
                if index not in edges:
                    self.faults.add("jumped", index, int(self.number[index - self.first]))
                    edges.add(index)
        for index in sorted(edges):
            self.outputs.edge(index)

    def begin(self, index, number):
        self.at = self.high = self.number[index - self.first] = number
        self.window.begin(number)
        self.window.put(number, index)
        self.most = max(self.most, number)

    def lose(self, first, count, index):
        self.faults.add("lost", index, first, count)

    def begins_anew(self, index):
        """Does the sender begin anew at this frame, whose step is not 1?"""
        step, near = self.step[index - 1 - self.low_index], index - self.low_index
        if step > IMPLAUSIBLE and self.period_s:
            return bool(self.time_ns[near] - self.time_ns[near - 1] < 0.5e9 * step * self.period_s)
        behind = self.step[near:near + SURE]
        return bool(step < 0 and len(behind) == SURE and (behind == 1).all())

    def walk(self, index, end):
        while index < end:
            index = self.smooth(index, end)
            if index < end:
                self.place(index)
                index += 1

    def smooth(self, index, end):
        """On over frames that follow each other, as long as they are the newest; the first one behind them."""
        if self.at < self.high:
            return index
        where = np.searchsorted(self.odd, index)
        until = min(int(self.odd[where]), end) if where < len(self.odd) else end
        if until > index:
            self.number[index - self.first:until - self.first] = self.at + np.arange(1, until - index + 1)
            self.window.put(self.at + 1, index, until - index)
            self.at = self.high = self.at + until - index
        return until

    def place(self, index):
        """One frame by itself."""
        number = self.at + int(self.step[index - 1 - self.low_index])
        if number > self.high:
            if number > self.high + 1 and self.begins_anew(index):
                self.anew(index, number)
                return
            self.window.miss(self.high + 1, number, index)
            self.window.put(number, index)
            self.high = number
        elif not self.place_older(index, number):
            self.anew(index, number)
            return
        self.at = self.number[index - self.first] = number

    def place_older(self, index, number):
        """False: the sender begins anew here."""
        window = self.window
        if number < window.base or number < window.low:
            return self.place_old(index, number)
        if window[number] >= 0:
            return self.place_again(index, number, window[number])
        window.put(number, index)
        self.swapped(index, number)
        return True

    def place_old(self, index, number):
        """Older than what the window holds."""
        before = self.outputs.find(number) if number >= self.window.low else None
        if before is not None:
            return self.place_again(index, number, before)
        if self.begins_anew(index):
            return False
        if number < self.window.base or self.floor is not None and number <= self.floor:
            self.faults.add("stale", index, number)
        else:
            self.window.put_below(number, index)
            self.swapped(index, number)
        return True

    def place_again(self, index, number, before):
        """A number that there was; frames that repeat a whole stretch are one fault."""
        equal = self.same(before, index)
        if not equal and self.begins_anew(index):
            return False
        kind = "repeated" if equal else "contradicting"
        if self.again == (kind, index, number):
            self.faults.grow(kind)
        else:
            self.faults.add(kind, index, number)
        self.again = (kind, index + 1, number + 1)
        return True

    def swapped(self, index, number):
        """It and those that overtook it did not come in their turn."""
        self.faults.add("swapped", index, number)
        near = slice(max(index - OVERTAKEN - self.first, 0), index + 1 - self.first)
        self.number[index - self.first] = number
        self.trusted[near] &= self.number[near] < number

    def anew(self, index, number):
        """The sender began anew, or a frame is left from before: its numbers stand behind all earlier ones, by whole turns of
        the counter."""
        self.window.close()
        self.floor = self.most = max(self.most, self.high)
        self.faults.add("restarted", index, number)
        self.anews.append(index)
        behind = self.most + 1 - number
        self.begin(index, number + self.turn * max(-(-behind // self.turn), 0))
