"""The newest numbers of a message's counter: which frame brought each, and what has not come yet.

    window = Window(keep, lose)
    window.begin(number)                # of the first frame
    window.put(number, index, count)    # frames from `index` on that follow each other
    window.miss(first, end, index)      # numbers that were skipped, as frame `index` showed
    window[number]                      # the frame that brought it, or -1 - (the frame that showed that it is missing)
    window.close()

What falls out of the window is settled: keep(numbers, indices) gets the frames in the order of their numbers,
lose(first, count, index) what never came.
"""

import numpy as np

WIDTH = 1 << 17


class Window:
    def __init__(self, keep, lose):
        self.keep, self.lose = keep, lose
        self.came = np.empty(WIDTH, np.int64)

    def begin(self, number):
        """Room for some that are older than the first."""
        self.base, self.low, self.end, self.pending = number - WIDTH // 4, number, number, None

    def __getitem__(self, number):
        return int(self.came[number - self.base])

    def room(self, number):
        if number < self.base + WIDTH:
            return
        base = number - WIDTH // 2
        self.settle(min(base, self.end))
        if (shift := base - self.base) < WIDTH:
            self.came[:WIDTH - shift] = self.came[shift:].copy()
        self.base = base

    def put(self, number, index, count=1):
        while count:
            self.room(number)
            part = min(count, self.base + WIDTH - number)
            self.came[number - self.base:number - self.base + part] = np.arange(index, index + part)
            number, index, count = number + part, index + part, count - part
            self.end = max(self.end, number)

    def miss(self, first, end, index):
        if end - first > WIDTH // 2:
            self.settle(self.end)
            cut = end - WIDTH // 2
            self.lost(first, cut - first, index)
            self.base = self.end = first = cut
        if first < end:
            self.room(end - 1)
            self.came[first - self.base:end - self.base] = -1 - index
            self.end = max(self.end, end)

    def put_below(self, number, index):
        """Older than all: what lies between is missing."""
        self.came[number + 1 - self.base:self.low - self.base] = -1 - index
        self.came[number - self.base], self.low = index, number

    def settle(self, end):
        first = max(self.low, self.base)
        if end <= first:
            return
        came = self.came[first - self.base:end - self.base]
        there = np.flatnonzero(came >= 0)
        self.keep(first + there, came[there])
        missing = np.flatnonzero(came < 0)
        if len(missing):
            shown = came[missing]
            edges = np.flatnonzero((np.diff(missing) != 1) | (np.diff(shown) != 0)) + 1
            starts = np.append(0, edges)
            for at, count in zip(starts.tolist(), np.diff(np.append(starts, len(missing))).tolist(), strict=True):
                self.lost(first + int(missing[at]), count, -1 - int(shown[at]))

    def lost(self, first, count, index):
        """What continues the one before is one with it."""
        if self.pending and (self.pending[0] + self.pending[1], self.pending[2]) == (first, index):
            self.pending[1] += count
            return
        self.flush()
        self.pending = [first, count, index]

    def flush(self):
        if self.pending:
            self.lose(*self.pending)
        self.pending = None

    def close(self):
        self.settle(self.end)
        self.flush()
