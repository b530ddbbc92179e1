"""Where a step of the clock lies among the frames of an interface.

    edge = first_behind(chunks, begin, count, steps)    # of steps[0], up to MOST_AT_ONCE; chunks(first): realtime stamps of the frames from one on

Each frame may be the first behind the step for which nothing is contradicted: by the readings on either side of the
step, the frame before it was not stamped behind the second one, nor it before the first one, and it did not come before the one
before it. A fall of the stamps can only be the step. Otherwise each of these frames is weighed: is the move of the
stamps before it, less the step (and those that follow, should it lie behind these, too), a usual one of this interface, or the move
as it is? The recorder tells of a step at once, which is
weighed, too. Where more than one frame remains likely, the instants between these are uncertain by the step, and the step says so.
"""

import numpy as np

MOST_USUAL = 2000  # moves on either side of the step by which the usual ones are known
SHARE = 4  # moves are alike that differ by less than this part of the step
SOON_NS = 100_000_000  # the recorder reads the clocks at once when one is set
LATE = 10  # doublings of likelihood that a frame loses when the recorder would have told of the step later than that
MOST_AT_ONCE = 4  # steps that one frame may lie behind, and the one before it before
RULED_OUT = 7  # doublings by which a frame is less likely than the best, and is ruled out: 1 in 128


def first_behind(chunks, begin, count, steps):
    """The first frame behind the first of the steps, of the frames from `begin` on; `count` when all came before it."""
    window = Window(steps)

    def stamp_of(k):
        return next(chunks(k))[0]

    if not window.may_be_before(stamp_of(begin)):
        return Edges(window, None, begin, begin).only(begin, stamp_of)
    start, middle = window.place(moved(chunks, begin), count)
    edges = Edges(window, Usual(chunks, begin, middle, abs(steps[0].size_ns) / SHARE), begin, start)
    for first, stamp, move in moved(chunks, max(start - 1, begin)):
        if edges.take(first, stamp, move):
            break
    else:
        edges.add(np.array([count]), np.zeros(1))
    return edges.chosen(count, stamp_of)


def moved(chunks, begin):
    """(number of the first frame, stamps, their moves from the frame before) of each chunk; the first of all has no move."""
    last = None
    for stamp in chunks(begin):
        if len(stamp):
            yield begin, stamp, np.diff(stamp, prepend=stamp[0] if last is None else last)
            begin, last = begin + len(stamp), stamp[-1]


class Window:
    """What the readings on either side of a step say of frames near it."""

    def __init__(self, steps):
        self.steps, self.step, self.width_ns = steps, steps[0], steps[0].width_ns
        self.soon_ns = self.step.after.mono_ns - SOON_NS if self.step.after.is_set else self.step.before.mono_ns - self.width_ns

    def if_before(self, stamp):
        """When a frame came, should it have come before the step."""
        return stamp - self.step.before.offset_ns

    def if_behind(self, stamp):
        return stamp - self.step.after.offset_ns

    def may_be_behind(self, stamp):
        return np.any([came >= step.before.mono_ns - step.width_ns for came, step in self.behind(stamp)], 0)

    def behind(self, stamp):
        """When a frame came, should it lie behind this step and no other; or behind the ones that follow, too."""
        return ((stamp - step.after.offset_ns, step) for step in self.steps)

    def ways(self, stamp, move):
        """(is it possible, the gap before the frame, doublings that it loses) of frames that are the first behind a step, or several."""
        for came, step in self.behind(stamp):
            gap = move - (step.after.offset_ns - self.step.before.offset_ns)
            possible = (came >= step.before.mono_ns - step.width_ns) & (gap >= -self.width_ns)
            yield possible, gap, LATE * (came < self.soon_ns)

    def may_be_before(self, stamp):
        return self.if_before(stamp) <= self.step.after.mono_ns + self.width_ns

    def place(self, parts, count):
        """(the first frame that may be behind the step, the first for which it may be over): frames in the middle."""
        start = count
        for first, stamp, move in parts:
            over = (self.if_before(stamp) > self.step.before.mono_ns) | (move < -self.width_ns)
            start = min([start, *(first + np.flatnonzero(self.may_be_behind(stamp) | over)[:1])])
            if over.any():
                return int(start), first + int(np.argmax(over))
        return int(start), count


class Usual:
    """The moves of an interface's stamps near a step."""

    def __init__(self, chunks, begin, middle, alike_ns):
        self.first, self.alike_ns, moves = max(begin, middle - MOST_USUAL), alike_ns, []
        for first, _, move in moved(chunks, self.first):
            self.end = min(first + len(move), middle + MOST_USUAL)
            moves.append(move[:self.end - first])
            if self.end == middle + MOST_USUAL:
                break
        self.moves = np.sort(np.concatenate(moves)[1:])

    def count(self, move):
        return np.searchsorted(self.moves, move + self.alike_ns, "right") - np.searchsorted(self.moves, move - self.alike_ns)

    def doublings(self, index, move, window, stamp):
        """How much likelier the frames' moves are with steps in them than without; a move does not speak for itself."""
        itself = (index > self.first) & (index < self.end)
        without = np.log2(np.maximum(self.count(move) - itself, 0) + 0.5)
        return np.max([np.where(possible, np.log2(self.count(gap) + 0.5) - lost, -np.inf) for possible, gap, lost in window.ways(stamp, move)], 0) - without


class Edges:
    """The frames that may be the first behind a step: of each likelihood the first and the last one."""

    def __init__(self, window, usual, begin, start):
        self.window, self.usual, self.begin, self.start = window, usual, begin, start
        self.found, self.over = {}, None  # {doublings: (first, last)}; the first frame that came behind the step in any case

    def take(self, first, stamp, move):
        """Frames as they come; can no later one be the first behind the step?"""
        window, index = self.window, np.arange(first, first + len(stamp))
        over = index[~window.may_be_before(stamp) & (index >= self.begin)][:1]
        likelier = self.usual.doublings(index, move, window, stamp)
        likelier[index < self.start] = -np.inf
        if first == self.begin:  # its move is not known
            likelier[0] = -LATE * (window.if_behind(stamp[0]) < window.soon_ns) if window.may_be_behind(stamp[0]) else -np.inf
        may = (likelier > -np.inf) & (index <= (over[0] if len(over) else index[-1]))
        fall = index[may & (move < -window.width_ns)][:1].tolist()
        if fall:
            self.found = {0.0: (fall[0], fall[0])}
            return True
        self.add(index[may], likelier[may])
        self.over = int(over[0]) if len(over) else None
        return len(over) > 0

    def add(self, index, likelier):
        likelier = np.rint(likelier)
        for one in np.unique(likelier).tolist():
            rows = index[likelier == one].tolist()
            self.found[one] = min(rows[0], *self.found.get(one, rows[:1])), max(rows[-1], *self.found.get(one, rows[-1:]))

    def only(self, edge, stamp_of):
        """There is no other one."""
        if self.window.may_be_behind(stamp_of(edge)):
            self.found = {0.0: (edge, edge)}
        self.over = edge
        return self.chosen(edge, stamp_of)

    def chosen(self, count, stamp_of):
        step = self.window.step
        if not self.found:  # the frames contradict the readings
            step.doubt(abs(step.size_ns), step.before.mono_ns, step.after.mono_ns)
            return count if self.over is None else self.over
        best = max(self.found)
        likely = [edges for likelier, edges in self.found.items() if likelier >= best - RULED_OUT]
        first, last = min(edge for edge, _ in likely), max(edge for _, edge in likely)
        if first < last:
            times = [int(when(stamp_of(k))) for k in (first, last - 1) for when in (self.window.if_before, self.window.if_behind)]
            step.doubt(abs(step.size_ns), min(times), max(times))
        return self.found[best][0]
