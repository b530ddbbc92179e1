"""The frames of a record, message by message: their order, their instants, their values."""

import numpy as np

from .clock import tick_times
from .refused import Refused
from .sequence import Fault, follow
from .events import monotonic

OVERTAKEN = 256  # frames before one that came too late among which those are looked for that overtook it
NO_DELAY_S = 10.0  # a frame whose stamp is further from its number's place than this was not late: a clock was set
PERIODS_SILENT = 3  # a message is silent when the others of its sender go on for longer


class Stream:
    """All frames of one message on one interface."""

    def __init__(self, message, source, record, rows, stamps):
        self.message, self.source = message, source
        self.short = record.length[rows] < message.length
        readable = record.length[rows] >= (message.counter.bytes if message.counter else message.length)
        self.unread = rows[~readable]  # too short even for the counter
        self.rows, self.short = rows[readable], self.short[readable]
        self.line = record.line[self.rows]
        self.short_lines = record.line[rows[record.length[rows] < message.length]]
        self.stamp_ns, self.converted = stamps[0][readable], stamps[1]
        self.record, self.sequence = record, None
        self.order = np.arange(len(self.rows))
        self.number = self.order
        self.faults = []
        if len(self.rows) and message.counter:
            self.follow()

    def follow(self):
        data, counter = self.record.data[self.rows], self.message.counter
        length = self.record.length[self.rows]

        def same(a, b):
            return length[a] == length[b] and bool((data[a] == data[b]).all())

        number = counter.raw(data).astype(np.int64) & (1 << self.message.counter_bits) - 1
        self.sequence = follow(number, self.message.counter_bits, self.stamp_ns, self.message.cycle_s, same)
        self.faults = list(self.sequence.faults)
        self.number, self.order = self.sequence.number, self.sequence.kept
        self.order = self.order[self.longest_life()[self.order]]

    def longest_life(self):
        """Which frames belong to the sender's longest life: nothing says how the ticks of one lie to another's, be it that
        the sender began anew, that a frame is left from before, or that no delay explains its stamp."""
        anew = [fault.index for fault in self.faults if fault.kind == "restarted"]
        if self.message.cycle_s:
            apart = np.diff(self.stamp_ns).astype(float) - np.diff(self.number) * (1e9 * self.message.cycle_s)
            jumps = np.flatnonzero(np.abs(apart) > NO_DELAY_S * 1e9) + 1
            jumps = [int(index) for index in jumps if index not in anew]
            self.faults += [Fault("jumped", index, int(self.number[index])) for index in jumps]
            anew = sorted(anew + jumps)
        edges = [0, *anew, len(self.rows)]
        lengths = np.diff(edges)
        longest = int(np.argmax(lengths))
        of_life = np.zeros(len(self.rows), bool)
        of_life[edges[longest]:edges[longest + 1]] = True
        return of_life

    def in_order(self):
        """Of the frames in use, those that neither came too late for their number nor overtook such a one: their
        stamps can be trusted to lie behind their ticks."""
        trusted = np.ones(len(self.rows), bool)
        for fault in self.faults:
            if fault.kind == "swapped":
                near = np.arange(max(fault.index - OVERTAKEN, 0), fault.index + 1)
                trusted[near[self.number[near] >= self.number[fault.index]]] = False
        return self.order[trusted[self.order]]

    @property
    def name(self):
        return f"{self.message.name} on {self.source}"

    def typical_period(self):
        """Seconds from frame to frame: what the DBC says, or more where the sender is slower."""
        steps = np.diff(self.stamp_ns)
        return max(self.message.cycle_s, float(np.median(steps)) / 1e9 if len(steps) else 0.0)

    def time_beyond(self, stamp_ns, side):
        """How long at least, by the number of its frames, this message was sent before (-1) or after (1) an instant."""
        frames = int(np.sum(side * (self.stamp_ns[self.order] - stamp_ns) > 0))
        return max(frames - 1, 0) * self.typical_period()

    def usable(self, name=None):
        """Indices of the frames that have all their bytes, and the signal, in the order of their numbers."""
        whole = self.order[~self.short[self.order]]
        return whole if name is None else whole[self.message.holds(name, self.record.data[self.rows[whole]])]

    def values(self, name, index):
        return self.message.decode(name, self.record.data[self.rows[index]])

    def counts(self, name, index):
        return self.message.fields[name].raw(self.record.data[self.rows[index]]).astype(np.int64)

    def find_late(self, group):
        """Adds a fault for each frame that came more than a period after its tick; answers all delays [s]."""
        delay = (self.stamp_ns[self.order] - group.zero_ns - group.time_of(self.number[self.order])) / 1e9
        late = self.order[delay > self.message.cycle_s]
        self.faults += [Fault("late", int(i), int(self.number[i])) for i in late]
        return delay


def streams_of(record, database, events, interface=None):
    """({(message, source): Stream}, [unknown (identifier, source, frames, first line)])."""
    if interface is not None and interface not in record.sources:
        raise Refused(2, f"--interface: {interface} is not in {record.path}, only {', '.join(record.sources)}")
    known, unknown = [], []
    for number, source in enumerate(record.sources):
        if interface is not None and source != interface:
            continue
        of_source = np.flatnonzero(record.source == number)
        stamp_ns, converted = monotonic(events, source, record.time_ns[of_source])
        identifiers = record.identifier[of_source]
        order = np.argsort(identifiers, kind="stable")
        kinds, first = np.unique(identifiers[order], return_index=True)
        for identifier, those in zip(kinds.tolist(), np.split(order, first[1:]), strict=True):
            message, rows = database.messages.get(identifier), of_source[those]
            if message:
                known.append(Stream(message, source, record, rows, (stamp_ns[those], converted)))
            else:
                unknown.append((identifier, source, len(rows), int(record.line[rows[0]])))
    return known, unknown


def find_silence(streams):
    """Faults where a message begins later or ends sooner than the others of its sender. How much later is counted in
    the others' frames: a record may stall, and a sender too, but frames that were sent in turn stay in turn."""
    for stream in streams:
        if not (stream.message.counter and stream.message.cycle_s and len(stream.order)):
            continue
        peers = [peer for peer in streams if peer is not stream and peer.source == stream.source and len(peer.rows)
                 and peer.message.sender and peer.message.sender == stream.message.sender and peer.message.cycle_s]  # fmt: skip
        period_s = stream.typical_period()
        for index, side in ((int(stream.order[0]), -1), (int(stream.order[-1]), 1)):
            silent_s = max((peer.time_beyond(stream.stamp_ns[index], side) for peer in peers), default=0.0)
            if silent_s > (PERIODS_SILENT + 0.5) * period_s:
                stream.faults.append(Fault("silent", index, int(stream.number[index]), int(silent_s / period_s)))


class TickGroup:
    """Messages of one sender whose counters number the same ticks."""

    def __init__(self, streams):
        self.streams, self.period_s = streams, streams[0].message.cycle_s
        first = streams[0]
        for stream in streams[1:]:
            turn = 1 << stream.message.counter_bits
            at, at_first = stream.order[0], first.order[0]
            time = (stream.stamp_ns[at] - first.stamp_ns[at_first]) / 1e9 / self.period_s
            apart = time - (stream.number[at] - first.number[at_first])
            stream.number = stream.number + turn * round(apart / turn)
        order = [s.in_order() for s in streams]
        number = np.concatenate([s.number[index] for s, index in zip(streams, order, strict=True)])
        stamp = np.concatenate([s.stamp_ns[index] for s, index in zip(streams, order, strict=True)])
        order = np.lexsort((stamp, number))
        number, stamp = number[order], stamp[order]
        earliest = np.append(True, np.diff(number) > 0)
        self.tick = number[earliest]
        self.time_ns, self.zero_ns = tick_times(self.tick, stamp[earliest], self.period_s)

    def time_of(self, number):
        """Instants of any ticks, from those whose frames came in order."""
        inside = np.interp(number, self.tick, self.time_ns)
        beyond = np.minimum(number - self.tick[0], 0) + np.maximum(number - self.tick[-1], 0)
        return inside + beyond * self.period_s * 1e9


def tick_groups(streams):
    """The groups of those streams that have ticks, the others each with instants of its own where it is cyclic."""
    groups = {}
    for stream in streams:
        if stream.message.counter and stream.message.cycle_s and len(stream.order) and len(stream.in_order()):
            shared = stream.message.sender if stream.message.sample_tick else stream.message.name
            key = (stream.source, stream.message.sample_tick, shared, stream.message.cycle_s)
            groups.setdefault(key, []).append(stream)
    return [TickGroup(members) for members in groups.values()]
