"""The lives of a sender: stretches between which nothing says how the ticks of one lie to another's, be it that the sender began
anew, that a frame is left from before, or that no delay explains its stamp.

    lives = Lives()
    lives.edge(index)                         # a life ends before this frame
    usable(lives.chosen(), stamp_of)          # those that can stand one behind the other in a recording
    shared([spans of one stream, ...])        # which lives of several messages are the same one of their sender
"""

import heapq
from array import array

LEAST_FRAMES = 20  # of a life beside the longest: what an adapter still held from before is none
MOST_LIVES = 1000  # of one message


class Lives:
    def __init__(self):
        self.begin, self.edges = 0, array("q")
        self.longest = (0, 0)

    def edge(self, index):
        if index - self.begin > self.longest[1] - self.longest[0]:
            self.longest = (self.begin, index)
        if index - self.begin >= LEAST_FRAMES:
            self.edges.extend((self.begin, index))
        self.begin = index

    def chosen(self):
        """Frames [first, end) of the longest ones, in the order of the record."""
        pairs = zip(self.edges[::2], self.edges[1::2], strict=True)
        return sorted(heapq.nlargest(MOST_LIVES, pairs, key=lambda life: life[1] - life[0])) or [self.longest]


def usable(lives, stamp_of):
    """The longest, and before and behind it those whose stamps rise from life to life."""
    middle = max(range(len(lives)), key=lambda k: lives[k][1] - lives[k][0])
    used = [lives[middle]]
    for life in lives[middle + 1:]:
        if rises(life, stamp_of) and stamp_of(life[0]) > stamp_of(used[-1][1] - 1):
            used.append(life)
    for life in reversed(lives[:middle]):
        if rises(life, stamp_of) and stamp_of(life[1] - 1) < stamp_of(used[0][0]):
            used.insert(0, life)
    return used


def rises(life, stamp_of):
    return stamp_of(life[0]) < stamp_of(life[1] - 1)


def shared(spans):
    """spans: of each stream a list of (life, first stamp, last stamp). Answers for each life of the sender {stream: [(its life, how
    long it lasts)]}, in the order of time: lives that lie beside each other for more than half of the shorter one are the same.
    A message may have several in one of another's: it was interrupted, or its restart was not seen there."""
    joined = []
    for begin, end, stream, life in sorted((begin, end, k, life) for k, own in enumerate(spans) for life, begin, end in own):
        if not joined or joined[-1]["end"] - begin <= 0.5 * min(end - begin, joined[-1]["end"] - joined[-1]["begin"]):
            joined.append({"begin": begin, "end": end, "members": {}})
        last = joined[-1]
        last["end"] = max(last["end"], end)
        last["members"].setdefault(stream, []).append((life, end - begin))
    return [one["members"] for one in joined]
