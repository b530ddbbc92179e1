"""The frames of a record, message by message: their order, their instants, their values.

    streams, unknown = streams_of(parts, names, ...)   # as they stand in the record, each in a spool
    stream.put_in_order(store)                         # by their counters: stream.ordered
"""

from dataclasses import dataclass

import numpy as np
from talus.refused import Refused

from .faults import Budget, Faults
from .events import Clocks
from .ranks import median, quantiles
from .lives import Lives, usable
from .sequence import SURE, Follower, Outputs
from .spool import CHUNK

PERIODS_SILENT = 3  # a message is silent when the others of its sender go on for longer
MOST_KINDS = 20_000  # messages and unknown identifiers, each on its interface
CLASSIC_BYTES = 8


def diffs(chunks):
    """Differences of neighbours, across the chunks' ends."""
    last = None
    for chunk in chunks:
        if len(chunk):
            yield np.diff(chunk) if last is None else np.diff(chunk, prepend=last)
            last = chunk[-1]


class Stream:
    """All frames of one message on one interface."""

    def __init__(self, message, source, store, budget):
        self.message, self.source, self.store = message, source, store
        self.least = message.counter.bytes if message.counter else message.length  # bytes without which a frame tells nothing
        self.width = max(message.length, CLASSIC_BYTES)
        self.frames = store.spool([("stamp_ns", "i8"), ("line", "i8"), ("length", "u1"), ("data", "u1", (self.width,))])
        self.faults, self.unread = Faults(budget), 0
        self.clock = None  # turns stamps of these lines into instants
        self.ordered, self.delay_s = None, []
        self.lives, self.used, self.shift = [], [], []  # of each life: frames [first, end), is it used, what its numbers lack

    def take(self, part, rows):
        """Frames as they come."""
        length = part.length[rows]
        for line in part.line[rows[length < self.message.length]].tolist():
            self.faults.add("short", line, 0)
        self.unread += int((length < self.least).sum())
        rows = rows[length >= self.least]
        data = np.zeros((len(rows), self.width), np.uint8)
        width = min(self.width, part.data.shape[1])
        data[:, :width] = part.data[rows, :width]
        self.frames.append_columns(part.time_ns[rows], part.line[rows], part.length[rows], data)

    def converted(self, rows):
        rows["stamp_ns"] = self.clock.convert(rows["stamp_ns"], rows["line"])
        return rows

    def put_in_order(self, store, scratch):
        """Follows the counter: the frames to use, in the order of their numbers, go to `ordered`, life by life."""
        self.ordered = store.spool([("number", "i8"), ("stamp_ns", "i8"), ("index", "i8"), ("life", "i4"), ("trusted", "?"), ("whole", "?"),
                                    ("data", "u1", (self.width,))])  # fmt: skip
        kept, trusted, lives = scratch.spool([("number", "i8"), ("index", "i8")]), scratch.spool([("trusted", "?")]), Lives()
        if self.message.counter and len(self.frames):
            self.follow(kept, trusted, lives)
        else:
            lives.edge(len(self.frames))
            for begin in range(0, len(self.frames), CHUNK):
                number = np.arange(begin, min(begin + CHUNK, len(self.frames)))
                kept.append_columns(number, number)
                trusted.append_columns(np.ones(len(number), bool))
        self.lives = usable(lives.chosen(), self.stamp_of)
        self.used, self.shift = np.ones(len(self.lives), bool), np.zeros(len(self.lives), np.int64)
        newest = 0
        for rows in kept.chunks():
            newest = self.keep(rows, trusted, newest)

    def keep(self, rows, trusted, newest):
        """Rows of the lives that count; the last of these."""
        begins, ends = np.array(self.lives, np.int64).reshape(-1, 2).T
        life = np.searchsorted(begins, rows["index"], "right") - 1
        inside = (life >= 0) & (rows["index"] < ends[life])
        inside &= life >= np.maximum.accumulate(np.append(newest, np.where(inside, life, 0)))[1:]  # no frame goes back to an earlier one
        rows, life = rows[inside], life[inside]
        frames = self.converted(self.frames.take(rows["index"]))
        self.ordered.append_columns(rows["number"], frames["stamp_ns"], rows["index"], life, trusted.take(rows["index"])["trusted"],
                                    frames["length"] >= self.message.length, frames["data"])  # fmt: skip
        return int(life[-1]) if len(life) else newest

    def stamp_of(self, index):
        return int(self.converted(self.frames.read(index, index + 1))["stamp_ns"][0])

    def follow(self, kept, trusted, lives):
        near = Near(self.frames)

        def find(number):
            place = kept.search("number", number)
            row = kept.read(place, place + 1)[0] if place < len(kept) else None
            return int(row["index"]) if row is not None and row["number"] == number else None

        outputs = Outputs(kept.append_columns, trusted.append_columns, find, lives.edge, self.faults)
        follower = Follower(self.message.counter_bits, self.message.cycle_s, near.same, outputs)
        for begin in range(0, len(self.frames), CHUNK):
            end, low = min(begin + CHUNK, len(self.frames)), max(begin - 1, 0)
            rows = self.converted(self.frames.read(low, min(end + SURE, len(self.frames))))
            near.hold(low, rows)
            counter = self.message.counter.raw(rows["data"]).astype(np.int64) & (1 << self.message.counter_bits) - 1
            follower.feed(begin, end, counter, rows["stamp_ns"], low)
        follower.close()

    @property
    def name(self):
        return f"{self.message.name} on {self.source}"

    def find_period(self):
        """Seconds from frame to frame: what the DBC says, or more where the sender is slower."""
        steps = median(lambda: diffs(self.converted(rows)["stamp_ns"] for rows in self.frames.chunks()))
        return max(self.message.cycle_s, (steps or 0.0) / 1e9)

    def end_frames(self):
        """The first and the last in the order of their numbers."""
        return [self.ordered.read(k, k + 1)[0] for k in (0, len(self.ordered) - 1)]

    def rows(self, life=None):
        """Chunks of `ordered`, or of one life in it, with the numbers that the group of this stream counts by."""
        for rows in self.ordered.chunks() if life is None else self.ordered.chunks(CHUNK, *self.place_of(life)):
            used = self.used[rows["life"]]
            rows = rows if used.all() else rows[used]
            rows["number"] += self.shift[rows["life"]]
            yield rows

    @property
    def outside(self):
        """How many frames are in no life that counts."""
        return len(self.frames) - sum(end - first for (first, end), used in zip(self.lives, self.used, strict=True) if used)

    def place_of(self, life):
        """Its first row of `ordered`, and the first behind it."""
        return tuple(self.ordered.search("life", life, side) for side in ("left", "right"))

    def first_numbers(self):
        """Of each life that counts, as rows() has them."""
        return [int(self.span_of(life)[0]["number"] + self.shift[life]) for life in np.flatnonzero(self.used).tolist()]

    def span_of(self, life):
        """First and last row of a life."""
        first, end = self.place_of(life)
        return self.ordered.read(first, first + 1)[0], self.ordered.read(end - 1, end)[0]

    def usable(self, field):
        """Chunks of the frames that have all their bytes, and the signal, in the order of their numbers."""
        for rows in self.rows():
            good = rows["whole"] & self.message.holds(field.name, rows["data"])
            yield rows if good.all() else rows[good]

    def has(self, field):
        return any(len(rows) for rows in self.usable(field))

    def find_late(self, group, store):
        """Adds a fault for each frame that came more than a period after its tick, and remembers how the delays spread."""
        delays = store.spool([("delay_s", "f8")])
        for rows in self.rows():
            delay = (rows["stamp_ns"] - group.zero_ns - group.time_of(rows["number"])) / 1e9
            for row in rows[delay > self.message.cycle_s]:
                self.faults.add("late", int(row["index"]), int(row["number"]))
            delays.append_columns(delay)
        self.delay_s = quantiles(lambda: (rows["delay_s"] for rows in delays.chunks()), (0.5, 0.999, 1.0))


class Near:
    """Frames by their number in the record, some at a time."""

    def __init__(self, frames):
        self.frames, self.held = frames, [(0, frames.read(0, 0))] * 2  # what was asked for last, and what is followed now

    def hold(self, low, rows):
        self.held[1] = (low, rows)

    def frame(self, index):
        for low, rows in self.held:
            if low <= index < low + len(rows):
                return rows[index - low]
        self.held[0] = (index, self.frames.read(index, min(index + 1024, len(self.frames))))
        return self.held[0][1][0]

    def same(self, a, b):
        a, b = self.frame(a), self.frame(b)
        return a["length"] == b["length"] and a["data"].tobytes() == b["data"].tobytes()


@dataclass
class Sorter:
    """Frames to their streams."""

    database: object
    store: object
    interface: str | None

    def __post_init__(self):
        self.streams, self.unknown, self.budget = {}, {}, Budget()

    def take(self, part, sources):
        key = part.source.astype(np.int64) << 32 | part.identifier
        order = np.argsort(key, kind="stable")
        kinds, first = np.unique(key[order], return_index=True)
        for kind, rows in zip(kinds.tolist(), np.split(order, first[1:]), strict=True):
            if self.interface in (None, sources[kind >> 32]):
                self.take_kind(kind, sources[kind >> 32], part, rows)

    def take_kind(self, kind, source, part, rows):
        message = self.database.messages.get(kind & 0xFFFFFFFF)
        if kind not in self.streams and kind not in self.unknown and len(self.streams) + len(self.unknown) >= MOST_KINDS:
            raise Refused(2, f"line {part.line[rows[0]]}: more than {MOST_KINDS} different identifiers")
        if message is None:
            frames, line = self.unknown.get(kind, (0, int(part.line[rows[0]])))
            self.unknown[kind] = frames + len(rows), line
            return
        if kind not in self.streams:
            self.streams[kind] = Stream(message, source, self.store, self.budget)
        self.streams[kind].take(part, rows)


def streams_of(record, parts, sorter, events):
    """([Stream], [unknown (identifier, source, frames, first line)]) of a record that is read here."""
    clocks = Clocks(events, sorter.store)
    for part in parts:
        if not len(part.line):
            continue
        sorter.take(part, record.sources)
        clocks.take(part, record.sources)
    if sorter.interface is not None and sorter.interface not in record.sources:
        raise Refused(2, f"--interface: {sorter.interface} is not in {record.path}, only {', '.join(record.sources)}")
    for _, stream in sorted(sorter.streams.items()):
        stream.clock = clocks.of(stream.source)
    unknown = [(kind & 0xFFFFFFFF, record.sources[kind >> 32], *found) for kind, found in sorted(sorter.unknown.items())]
    return [stream for _, stream in sorted(sorter.streams.items())], unknown


# ---- silence -----------------------------------------------------------------------------


def is_peer(a, b):
    return a is not b and a.source == b.source and a.message.sender and a.message.sender == b.message.sender


def frames_beyond(stream, instants):
    """(how many frames came before, how many after) each of some instants."""
    order = np.argsort(instants)
    at = np.array(instants)[order]
    before, upto = np.zeros(len(at), np.int64), np.zeros(len(at), np.int64)
    for rows in stream.rows():
        stamps = np.sort(rows["stamp_ns"])
        before += np.searchsorted(stamps, at)
        upto += np.searchsorted(stamps, at, "right")
    counted = np.empty((2, len(at)), np.int64)
    counted[:, order] = before, len(stream.ordered) - upto
    return counted


def find_silence(streams):
    """Faults where a message begins later or ends sooner than the others of its sender. How much later is counted in
    the others' frames: a record may stall, and a sender too, but frames that were sent in turn stay in turn."""
    cyclic = [stream for stream in streams if stream.message.cycle_s and len(stream.frames)]
    period_s = {id(stream): stream.find_period() for stream in cyclic if any(is_peer(stream, other) for other in streams)}
    judged = [stream for stream in cyclic if stream.message.counter and len(stream.ordered) and id(stream) in period_s]
    silent_s = {id(stream): [0.0, 0.0] for stream in judged}
    for peer in cyclic:
        others = [stream for stream in judged if is_peer(stream, peer)]
        if not others:
            continue
        instants = [int(frame["stamp_ns"]) for stream in others for frame in stream.end_frames()]
        before, after = frames_beyond(peer, instants)
        for k, stream in enumerate(others):
            for side, frames in enumerate((before[2 * k], after[2 * k + 1])):
                longest = silent_s[id(stream)]
                longest[side] = max(longest[side], max(int(frames) - 1, 0) * period_s[id(peer)])
    for stream in judged:
        period = period_s[id(stream)]
        for frame, silent in zip(stream.end_frames(), silent_s[id(stream)], strict=True):
            if silent > (PERIODS_SILENT + 0.5) * period:
                stream.faults.add("silent", int(frame["index"]), int(frame["number"]), int(silent / period))
